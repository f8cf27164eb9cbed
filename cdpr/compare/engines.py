"""Who takes part in a comparison, who judges, and by which standard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from cdpr.errors import CdprError, PluginError
from cdpr.scenario import Scenario

# By which an engine is judged:
#   scheme   the judge offers the engine's scheme: run so, it must give the same but for round-off
#   order    nobody else has its scheme: extrapolated to a vanishing step it must be the judge's solution
#   none     the plant is another one: the distance is told
Standard = Literal["scheme", "order", "none"]

OWN_CABLES = "ideal"  # what the property `cables` is where a backend declares none: tensions at anchors or exits

CONTINUOUS: tuple[object, ...] = ("C0", "C1", "Cinf")


@dataclass(frozen=True)
class Engine:
    """A backend with the options of a scenario, and what it declares with them."""

    name: str
    order: int  # 0 where none is declared
    scheme: str  # "" where none is declared
    schemes: tuple[str, ...]  # that its option `scheme` offers
    cables: str  # the model of the cables

    def standard(self, judge: Engine) -> Standard:
        """Return by which standard the engine is held against `judge`."""
        if self.order < 1 or self.cables != judge.cables:
            return "none"
        return "scheme" if self.scheme in judge.schemes else "order"


@dataclass(frozen=True)
class Field:
    """The engines of a comparison.

    Attributes:
        judge: the one of highest order; it always runs.
        engines: the others, in the order given.
        absent: reason by name of those that cannot run here.
    """

    judge: Engine
    engines: tuple[Engine, ...]
    absent: dict[str, str]


def field(scenario: Scenario, names: Sequence[str] | None) -> Field:
    """Choose judge and engines; `names` are backends, None for all.

    Raises PluginError where a named one is unknown or not installed, CdprError where there is nothing to compare.
    """
    found = scenario.plugins
    absent: dict[str, str] = {}
    for name in dict.fromkeys(found.names("backend") if names is None else names):
        entry = found.get("backend", name)
        if entry.missing and names is None:
            absent[name] = f"not installed: {entry.remedy}"
        elif entry.missing:
            entry.load()  # says what is missing and how to get it
    here = []
    for name in found.names("backend"):
        if not found.get("backend", name).missing:
            try:
                here.append(engine_of(scenario, name))
            except PluginError:  # it needs options that the scenario does not give
                if names is not None and name in names:
                    raise
    # By what it can, not by the scheme that the scenario has it run.
    judge = min(here, key=lambda one: (-_order(found.get("backend", one.name).info.properties), -len(one.schemes)))
    wanted = [engine.name for engine in here] if names is None else list(dict.fromkeys(names))
    engines = tuple(engine for name in wanted for engine in here if engine.name == name != judge.name)
    if not engines:
        others = "; ".join(f"{name}: {reason}" for name, reason in absent.items())
        hint = f" ({others})" if others else f"; there are {', '.join(found.names('backend'))}"
        raise CdprError(f"nothing to compare: '{judge.name}' is the judge, and no other backend is chosen{hint}")
    return Field(judge, engines, absent)


def engine_of(scenario: Scenario, name: str) -> Engine:
    """Return what a backend declares with the scenario's options; PluginError where it is unknown."""
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
    """The order that a plugin declares; 0 where it declares none."""
    order = properties.get("order", 0)
    return order if isinstance(order, int) else 0


def finest_scheme(scenario: Scenario, judge: Engine) -> str:
    """Return the scheme of the judge that is of highest order, "" where that is the scenario's."""
    key = f"backend_options.{judge.name}.scheme"
    orders = {name: engine_of(scenario.with_changes({key: name}), judge.name).order for name in judge.schemes}
    best = max(orders, key=orders.__getitem__, default="")
    return best if best and orders[best] > judge.order else ""


def is_continuous(scenario: Scenario) -> bool:
    """Whether the tensions follow the state without jumps: the solver declares it, or the controller commands them."""
    found = scenario.plugins
    controller = found.get("controller", scenario.controller.type)
    if controller.info.properties.get("output") == "command":
        return True
    solver = found.get("solver", scenario.solver.type)
    return solver.properties(scenario.solver_options).get("continuity") in CONTINUOUS  # type: ignore[arg-type]
