"""Events of a run, one module per type, and their table. To add a type, write its module and list it here."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Annotated, get_args

from pydantic import Field

from cdpr.scenario.events.contact import Contact
from cdpr.scenario.events.event import CableEvent, ScenarioEvent, first_sample, guarding, redirected
from cdpr.scenario.events.external_command import ExternalCommand
from cdpr.scenario.events.faults import CableBreak, CableJam
from cdpr.scenario.events.limit_changes import limit_changes
from cdpr.scenario.events.limits import TensionLimits
from cdpr.scenario.events.loads import Sine, Wrench
from cdpr.scenario.events.options import SetOption
from cdpr.scenario.events.stop import EmergencyStop
from cdpr.scenario.events.target import Target

__all__ = [
    "EVENTS",
    "MAX_EVENTS",
    "AnyEvent",
    "ScenarioEvent",
    "broken",
    "first_sample",
    "guarding",
    "limit_changes",
    "limits_change",
    "redirected",
]

MAX_EVENTS = 1000

AnyEvent = Annotated[
    Wrench
    | Sine
    | CableBreak
    | CableJam
    | TensionLimits
    | EmergencyStop
    | Target
    | SetOption
    | ExternalCommand
    | Contact,
    Field(discriminator="type"),
]

EVENTS: tuple[type[ScenarioEvent], ...] = get_args(get_args(AnyEvent)[0])


def limits_change(kinds: Collection[str]) -> bool:
    """Return True if an event of these kinds changes tension limits."""
    return any(event.changes_limits for event in EVENTS if event.kind() in kinds)


def broken(events: Sequence[ScenarioEvent], cables: Sequence[str], step: float) -> tuple[tuple[int, float], ...]:
    """Return the indices of `cables` that break, and the times (s) of the first samples after it."""
    breaks = [event for event in events if isinstance(event, CableEvent) and event.breaks]
    return tuple((cables.index(str(event.cable)), first_sample(event.time, step) * step) for event in breaks)
