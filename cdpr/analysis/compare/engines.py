"""Selection of the engines, the judge and the standards of a comparison."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from cdpr.base.errors import CdprError, PluginError
from cdpr.plugins.controller import COMMANDS
from cdpr.scenario import Scenario

# Standards: scheme: the judge offers the engine's scheme, and both must agree but for round-off; order: no other engine
# has the scheme, and its extrapolation to a vanishing step must equal the judge's solution; none: the plant differs,
# and the difference is only reported
Standard = Literal["scheme", "order", "none"]

OWN_CABLES = "ideal"  # property `cables` of backends that declare none: tensions at anchors or exits

CONTINUOUS: tuple[object, ...] = ("C0", "C1", "Cinf")


@dataclass(frozen=True)
class Engine:
    """Backend with the options of a scenario, and its declared properties."""

    name: str
    order: int  # 0 if not declared
    scheme: str  # "" if not declared
    schemes: tuple[str, ...]  # values of its option `scheme`
    cables: str  # cable model

    def standard(self, judge: Engine) -> Standard:
        """Return the standard by which the engine is compared with `judge`."""
        if self.order < 1 or self.cables != judge.cables:
            return "none"
        return "scheme" if self.scheme in judge.schemes else "order"


@dataclass(frozen=True)
class Field:
    """Engines of a comparison.

    Attributes:
        judge: engine of the highest order; it always runs.
        engines: the others, in the given order.
        absent: reason by name for engines that cannot run here.
    """

    judge: Engine
    engines: tuple[Engine, ...]
    absent: dict[str, str]


def field(scenario: Scenario, names: Sequence[str] | None) -> Field:
    """Choose the judge and the engines.

    Args:
        scenario: the scenario.
        names: backends; None for all.

    Raises:
        PluginError: if a named backend is unknown or not installed.
        CdprError: if there is nothing to compare.
    """
    found = scenario.plugins
    absent: dict[str, str] = {}
    for name in dict.fromkeys(found.names("backend") if names is None else names):
        entry = found.get("backend", name)
        if entry.missing and names is None:
            absent[name] = f"not installed: {entry.remedy}"
        elif entry.missing:
            entry.load()  # raises an error with the remedy
    here = []
    for name in found.names("backend"):
        if not found.get("backend", name).missing:
            try:
                here.append(engine_of(scenario, name))
            except PluginError:  # the scenario lacks options that it requires
                if names is not None and name in names:
                    raise
    # by its capabilities, not by the scheme set in the scenario
    judge = min(here, key=lambda one: (-_order(found.get("backend", one.name).info.properties), -len(one.schemes)))
    wanted = [engine.name for engine in here] if names is None else list(dict.fromkeys(names))
    engines = tuple(engine for name in wanted for engine in here if engine.name == name != judge.name)
    if not engines:
        others = "; ".join(f"{name}: {reason}" for name, reason in absent.items())
        hint = f" ({others})" if others else f"; allowed: {', '.join(found.names('backend'))}"
        raise CdprError(f"nothing to compare: '{judge.name}' is the judge, and no other backend is chosen{hint}")
    return Field(judge, engines, absent)


def engine_of(scenario: Scenario, name: str) -> Engine:
    """Return the declared properties of a backend with the scenario's options.

    Raises:
        PluginError: if the backend is unknown.
    """
    declared = scenario.plugins.get("backend", name).properties(scenario.backend_options(name))  # type: ignore[arg-type]
    schemes = declared.get("schemes", ())
    return Engine(
        name=name,
        order=_order(declared),
        scheme=str(declared.get("scheme", "")),
        schemes=tuple(schemes) if isinstance(schemes, (list, tuple)) else (),
        cables=str(declared.get("cables", OWN_CABLES)),
    )


def _order(properties: Mapping[str, object]) -> int:
    """Return the order that a plugin declares; 0 if none."""
    order = properties.get("order", 0)
    return order if isinstance(order, int) else 0


def finest_scheme(scenario: Scenario, judge: Engine) -> str:
    """Return the judge's scheme of the highest order; "" if the scenario already uses it."""
    key = f"backend_options.{judge.name}.scheme"
    orders = {name: engine_of(scenario.with_changes({key: name}), judge.name).order for name in judge.schemes}
    best = max(orders, key=orders.__getitem__, default="")
    return best if best and orders[best] > judge.order else ""


def is_continuous(scenario: Scenario) -> bool:
    """Return True if tensions follow the state without jumps.

    Either the solver declares continuity or the controller commands the tensions.
    """
    found = scenario.plugins
    controller = found.get("controller", scenario.controller.type)
    if controller.info.properties.get("output") in COMMANDS:
        return True
    solver = found.get("solver", scenario.solver.type)
    return solver.properties(scenario.solver_options).get("continuity") in CONTINUOUS  # type: ignore[arg-type]
