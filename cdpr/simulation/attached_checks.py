"""Checks of platform and attached bodies for the plugins of a scenario, before a run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cdpr.base.errors import CdprError, PluginError
from cdpr.base.problems import Path
from cdpr.mechanics.attachments import with_attachments
from cdpr.mechanics.body_frame import BodyFrame
from cdpr.plugins import Controller
from cdpr.plugins.inertia import check_range
from cdpr.plugins.registry import Registered
from cdpr.scenario import Scenario
from cdpr.scenario.events import ScenarioEvent


def out_of_range(scenario: Scenario, backend: Registered) -> Iterator[tuple[Path, CdprError]]:
    """Yield path and error of the platform, and of events whose bodies take it out of the range of a backend.

    The range is that of the properties `smallest` and `slimmest`, see `cdpr.plugins.inertia.check_range`.
    """
    declared = backend.properties(scenario.backend_options(backend.info.name))  # type: ignore[arg-type]
    smallest, slimmest = (_number(declared.get(name)) for name in ("smallest", "slimmest"))
    if not smallest and not slimmest:
        return
    engine = f"backend '{backend.info.name}'"
    try:
        check_range(BodyFrame(scenario.robot), engine, smallest, slimmest)
    except CdprError as error:
        yield ("robot", "platform"), error
        return
    spans = [(i, event.attachment(scenario.simulation.control_step)) for i, event in enumerate(scenario.events)]
    for i, span in spans:
        if span is None or span.first >= span.end:
            continue
        bodies = [other.body for _, other in spans if other is not None and other.first <= span.first < other.end]
        try:
            check_range(BodyFrame(with_attachments(scenario.robot, bodies)), engine, smallest, slimmest)
        except CdprError as error:
            event = scenario.events[i]
            text = f"event '{event.type}' at {event.time:g} s: with the attached bodies, {error}"
            yield ("events", i), type(error)(text)


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else 0.0


def check_known_mass(events: Sequence[ScenarioEvent], controller: Controller, solver: Registered, of: Scenario) -> None:
    """Reject an event with a mass that is known to a controller or a solver that cannot take it during a run."""
    for event in events:
        span = event.attachment(of.simulation.control_step)
        if span is None or not span.body.known:
            continue
        known = isinstance(controller, Controller) and type(controller).renew is not Controller.renew
        plugin = f"controller '{of.controller.type}'"
        if known and not solver.properties(of.solver_options).get("platform_independent"):  # type: ignore[arg-type]
            known, plugin = False, f"solver '{of.solver.type}'"
        if not known:
            raise PluginError(
                f"event '{event.type}' at {event.time:g} s: {plugin} cannot take a known mass during a run: set "
                "known: false, or choose another"
            )
