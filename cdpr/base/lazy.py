"""Names that are imported when first used: submodules of a package, and functions of higher layers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

# Methods that users expect of a class but a higher layer implements. No module imports a higher layer, not even in a
# function; these names are resolved at the call, only here.
LATE = {
    "Robot._repr_html_": "cdpr.ui.report.pages.notebook:of_robot",
    "Robot.save": "cdpr.scenario.sound_robot:save_robot",
    "Robot.to_dict": "cdpr.scenario.sound_robot:robot_dict",
    "Run._repr_html_": "cdpr.ui.report.pages.notebook:of_run",
    "Run.plot": "cdpr.ui.report.figures.run:plot",
    "Run.summary": "cdpr.log.summary:summarise",
    "Run.to_pandas": "cdpr.log.export:to_pandas",
    "Scenario._repr_html_": "cdpr.ui.report.pages.notebook:of_scenario",
    "Section": "cdpr.config.arguments:from_arguments",
    "Simulation._repr_html_": "cdpr.ui.report.pages.notebook:of_simulation",
    "keys_of_numbers": "cdpr.cables:keys_of_numbers",
    "names_of_models": "cdpr.cables:names_of_models",
    "names_of_winch_types": "cdpr.cables:names_of_winch_types",
    "robot_data": "cdpr.scenario.from_python:robot_data",
}


def late(name: str) -> Any:
    """Return the function of a name in `LATE`."""
    module, _, attribute = LATE[name].partition(":")
    return getattr(import_module(module), attribute)


def lazily(package: str, homes: Mapping[str, str] = {}) -> Callable[[str], object]:
    """Return the `__getattr__` of a package: names from the modules in `homes`, and all its submodules.

    Packages define it outside `TYPE_CHECKING`, since type checkers would otherwise accept any name; the same names are
    also imported `if TYPE_CHECKING`.
    """

    def get(name: str) -> object:
        if name in homes:
            return getattr(import_module(homes[name]), name)
        if not name.startswith("_"):
            module = f"{package}.{name}"
            try:
                return import_module(module)
            except ModuleNotFoundError as error:
                if error.name != module:
                    raise
        raise AttributeError(f"module '{package}' has no attribute {name!r}")

    return get
