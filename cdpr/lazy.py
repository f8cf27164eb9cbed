"""Names that are imported when they are first used: of a package's own modules, and of rooms above."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

# What users expect of a class though a module above it makes it. No module imports one above, not even in a function:
# it is looked for when it is called, here and nowhere else.
LATE = {
    "Robot._repr_html_": "cdpr.report.pages.notebook:of_robot",
    "Run._repr_html_": "cdpr.report.pages.notebook:of_run",
    "Run.plot": "cdpr.report.figures.run:plot",
    "Run.summary": "cdpr.log.summary:summarise",
    "Run.to_pandas": "cdpr.log.export:to_pandas",
    "Scenario._repr_html_": "cdpr.report.pages.notebook:of_scenario",
    "Simulation._repr_html_": "cdpr.report.pages.notebook:of_simulation",
}


def late(name: str) -> Any:
    """Return what stands behind a name in `LATE`."""
    module, _, attribute = LATE[name].partition(":")
    return getattr(import_module(module), attribute)


def lazily(package: str, homes: Mapping[str, str] = {}) -> Callable[[str], object]:
    """Return the `__getattr__` of a package: names from the modules in `homes`, and all its own modules.

    Packages define it where type checkers do not look, for they would then believe that every name exists; the same
    names stand beside it, imported `if TYPE_CHECKING`.
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
