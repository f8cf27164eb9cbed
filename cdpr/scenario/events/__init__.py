"""Events of a run, one module per type, and their table. To add a type, write its module and list it here.

Example:
    >>> import cdpr
    >>> cdpr.events.Wrench(time=0.5, duration=0.1, force=[100.0, 0.0, 0.0]).force
    (100.0, 0.0, 0.0)
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Annotated

from cdpr.base.kinds import Kinds
from cdpr.base.lazy import lazily
from cdpr.scenario.events.event import CableEvent, ScenarioEvent, first_sample, guarding, redirected, redirecting

if TYPE_CHECKING:
    from cdpr.scenario.events.contact import Contact
    from cdpr.scenario.events.external_command import ExternalCommand
    from cdpr.scenario.events.faults import CableBreak, CableJam
    from cdpr.scenario.events.limits import TensionLimits
    from cdpr.scenario.events.loads import Sine, Wrench
    from cdpr.scenario.events.options import SetOption
    from cdpr.scenario.events.payload import Payload
    from cdpr.scenario.events.sensor_bump import SensorBump
    from cdpr.scenario.events.sensor_failure import SensorFailure
    from cdpr.scenario.events.sensor_occlusion import SensorOcclusion
    from cdpr.scenario.events.stop import EmergencyStop
    from cdpr.scenario.events.target import Target

__all__ = [
    "EVENTS",
    "MAX_EVENTS",
    "AnyEvent",
    "CableBreak",
    "CableJam",
    "Contact",
    "EmergencyStop",
    "ExternalCommand",
    "Payload",
    "ScenarioEvent",
    "SensorBump",
    "SensorFailure",
    "SensorOcclusion",
    "SetOption",
    "Sine",
    "Target",
    "TensionLimits",
    "Wrench",
    "broken",
    "end_of_commands",
    "first_sample",
    "guarding",
    "limits_change",
    "logged_mass_changes",
    "mass_changes",
    "redirected",
    "redirecting",
]

MAX_EVENTS = 1000

EVENTS: Kinds[ScenarioEvent] = Kinds(
    {
        "wrench": "cdpr.scenario.events.loads:Wrench",
        "sine": "cdpr.scenario.events.loads:Sine",
        "cable_break": "cdpr.scenario.events.faults:CableBreak",
        "cable_jam": "cdpr.scenario.events.faults:CableJam",
        "limits": "cdpr.scenario.events.limits:TensionLimits",
        "emergency_stop": "cdpr.scenario.events.stop:EmergencyStop",
        "target": "cdpr.scenario.events.target:Target",
        "set": "cdpr.scenario.events.options:SetOption",
        "outside": "cdpr.scenario.events.external_command:ExternalCommand",
        "contact": "cdpr.scenario.events.contact:Contact",
        "payload": "cdpr.scenario.events.payload:Payload",
        "sensor_failure": "cdpr.scenario.events.sensor_failure:SensorFailure",
        "sensor_occlusion": "cdpr.scenario.events.sensor_occlusion:SensorOcclusion",
        "sensor_bump": "cdpr.scenario.events.sensor_bump:SensorBump",
    }
)
AnyEvent = Annotated[ScenarioEvent, EVENTS]


def limits_change(kinds: Collection[str]) -> bool:
    """Return True if an event of these kinds changes tension limits."""
    return any(EVENTS[kind].changes_limits for kind in kinds if kind in EVENTS)


def mass_changes(events: Sequence[ScenarioEvent]) -> bool:
    """Return True if an event changes the mass of the platform."""
    return any(event.changes_mass for event in events)


def logged_mass_changes(events: Sequence[ScenarioEvent]) -> bool:
    """Return True if an event changes the mass of the platform, and the run logs its energy."""
    return any(event.logs_energy for event in events)


def end_of_commands(events: Sequence[ScenarioEvent], step: float) -> float:
    """Return the first sample at which no external command replaces an answer; infinity without a stop."""
    return min((first_sample(event.time, step) for event in events if event.ends_commands), default=math.inf)


def broken(events: Sequence[ScenarioEvent], cables: Sequence[str], step: float) -> tuple[tuple[int, float], ...]:
    """Return the indices of `cables` that break, and the times (s) of the first samples after it."""
    breaks = [event for event in events if isinstance(event, CableEvent) and event.breaks]
    return tuple((cables.index(str(event.cable)), first_sample(event.time, step) * step) for event in breaks)


if not TYPE_CHECKING:  # imported when first used
    _homes = (home.partition(":") for home in EVENTS.homes.values())
    __getattr__ = lazily(__name__, {name: module for module, _, name in _homes})

    def __dir__() -> list[str]:
        return __all__
