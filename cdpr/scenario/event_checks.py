"""Events that can happen: to cables that there are, in an order that makes sense."""

from __future__ import annotations

import json
from collections.abc import Sequence

from pydantic import TypeAdapter, ValidationError

from cdpr.model import DOF_NAMES
from cdpr.scenario.checks import Checks
from cdpr.scenario.event_schema import (
    AnyEvent,
    CableBreak,
    CableFault,
    CableJam,
    EmergencyStop,
    Load,
    ScenarioEvent,
    Sine,
    TensionLimits,
    first_sample,
)
from cdpr.scenario.problems import exact, nearest
from cdpr.scenario.robot_schema import TensionSection, cable_name, limits
from cdpr.scenario.schema import Simulation

EVENT: TypeAdapter[ScenarioEvent] = TypeAdapter(AnyEvent)

Places = list[tuple[int, ScenarioEvent]]  # with the index in the file


class EventChecks(Checks):
    """Checks the events that are right by themselves."""

    def run(self) -> None:
        """Report everything that is wrong."""
        events = self._read()
        simulation = self.section(Simulation, ("simulation",))
        if simulation:
            self._against_steps(events, simulation.control_step)
        self._against_guide(events)
        cables = list(self.cables(("robot",)))
        given = self.document.get(("robot", "cables"))
        if not isinstance(given, list) or len(cables) != len(given):
            return  # names and limits are not known
        names = [cable_name(cable, i) for i, cable in cables]
        known = [(i, named(event, names)) for i, event in events if self._cable_exists(i, event, names)]
        known.sort(key=lambda place: place[1].time)
        self._need_ideal_cables(known)
        self._order(known)
        common = self.section(TensionSection, ("robot", "tension"))
        both = () if common is None else (common.min, common.max)
        if common and all(not isinstance(value, list) or len(value) == len(cables) for value in both):
            self._limits(
                known, {name: limits(common, cable, i) for name, (i, cable) in zip(names, cables, strict=True)}
            )

    def _read(self) -> Places:
        given = self.document.get(("events",))
        events: Places = []
        for i, item in enumerate(given if isinstance(given, list) else ()):
            try:
                events.append((i, EVENT.validate_json(json.dumps(item))))
            except ValidationError:
                continue  # has been reported
        return events

    def _against_steps(self, events: Places, step: float) -> None:
        for i, event in events:
            if isinstance(event, CableJam) and first_sample(event.time, step) < 1:
                early = exact(event.time)
                text = f"must be at least control_step, {exact(step)} (s), for no tension is there before, got {early}"
                self.say(("events", i, "time"), text)
            if isinstance(event, Load) and event.duration is not None and event.duration < step * (1.0 - 1e-9):
                held = exact(event.duration)
                text = f"must be at least control_step, {exact(step)} (s), for it is held so long, got {held}"
                self.say(("events", i, "duration"), text)
            if isinstance(event, Sine) and event.frequency * step >= 0.5:
                text = f"must be less than half of the control rate, {0.5 / step:g} (Hz), got {exact(event.frequency)}"
                self.say(("events", i, "frequency"), text)

    def _against_guide(self, events: Places) -> None:
        """Tell of wrenches that move nothing, for the guide takes all of them."""
        dof = self.directions(("robot", "dof"))
        for i, event in events:
            if dof and isinstance(event, Load):
                acts = [
                    name for name, part in zip(DOF_NAMES, (*event.force, *event.moment), strict=True) if part != 0.0
                ]
                if acts and not set(acts) & set(dof):
                    text = f"acts along {', '.join(acts)} only, which the guide takes entirely: it has no effect"
                    self.warn(("events", i), f"{text}; the robot moves along {', '.join(dof)}")

    def _cable_exists(self, i: int, event: ScenarioEvent, names: Sequence[str]) -> bool:
        cable = getattr(event, "cable", None)
        if isinstance(cable, int) and not 1 <= cable <= len(names):
            self.say(("events", i, "cable"), f"cables are numbered from 1 to {len(names)}, got {cable}")
            return False
        if isinstance(cable, str) and cable not in names:
            text = f"no cable is named '{cable}': {nearest(cable, names)}there are {', '.join(names)}"
            self.say(("events", i, "cable"), text)
            return False
        return True

    def _need_ideal_cables(self, events: Places) -> None:
        model = self.document.get(("robot", "cable", "model"))
        if self.document.get(("actuators",)) is not None:
            text = "happens to ideal cables only, and there are actuators: remove it or them"
        elif model in ("rigid", "elastic"):
            text = f"happens to ideal cables only, and robot.cable.model is {model}: remove it or set that to ideal"
        else:
            return
        for i, event in events:
            if isinstance(event, CableFault):
                self.say(("events", i, "type"), text)

    def _order(self, events: Places) -> None:
        """Report what cannot happen after what has happened; `events` stand in the order of time."""
        fate: dict[str, tuple[str, float]] = {}  # of a cable: what and when
        stopped: float | None = None
        for i, event in events:
            if isinstance(event, EmergencyStop):
                if stopped is not None:
                    self.say(
                        ("events", i),
                        f"the robot is stopped already at {exact(stopped)} s; one emergency stop is allowed",
                    )
                stopped = event.time
            if isinstance(event, CableFault | TensionLimits) and isinstance(event.cable, str):
                breaks = isinstance(event, CableBreak)
                what, since = fate.get(event.cable, ("", 0.0))
                if what and (what == "broken" or not breaks):
                    self.say(("events", i), f"cable '{event.cable}' is {what} already, since {exact(since)} s")
                elif isinstance(event, CableFault):
                    fate[event.cable] = ("broken" if breaks else "jammed", event.time)

    def _limits(self, events: Places, present: dict[str, tuple[float, float]]) -> None:
        """Report limits that contradict each other; `present` are those of each cable at first."""
        unilateral = self.document.get(("robot", "unilateral")) is not False
        set_at: dict[tuple[str, str], float] = {}
        for i, event in events:
            if not isinstance(event, TensionLimits):
                continue
            for name in present if event.cable is None else (str(event.cable),):
                text = _contradiction(event, name, present, set_at, unilateral)
                if text:
                    self.say(("events", i), text)
                    break  # limits of all cables that are wrong are one problem


def _contradiction(
    event: TensionLimits,
    name: str,
    present: dict[str, tuple[float, float]],
    set_at: dict[tuple[str, str], float],
    unilateral: bool,
) -> str:
    """Change the limits of one cable in `present`; return what is wrong with that, if anything."""
    given = {"min": event.min, "max": event.max}
    twice = [key for key, value in given.items() if value is not None and set_at.get((name, key)) == event.time]
    set_at.update({(name, key): event.time for key, value in given.items() if value is not None})
    low, high = present[name]
    low, high = low if event.min is None else event.min, high if event.max is None else event.max
    present[name] = low, high
    if twice:
        return f"{twice[0]} of cable '{name}' is set twice at {exact(event.time)} s"
    if unilateral and low < 0:
        return f"min must be at least 0 (N), got {exact(low)}: a cable cannot push"
    if low > high or high <= 0:
        found = f"{exact(low)} to {exact(high)}"
        return f"cable '{name}' would have the limits {found} (N): min must not exceed max, max be positive"
    return ""


def named(event: ScenarioEvent, names: Sequence[str | None]) -> ScenarioEvent:
    """Return the event with its cable's name in place of the number; `names` are those of all cables."""
    cable = getattr(event, "cable", None)
    return event.model_copy(update={"cable": names[cable - 1]}) if isinstance(cable, int) else event


def beyond(events: Sequence[ScenarioEvent], simulation: Simulation) -> list[int]:
    """Return the indices of the events that lie beyond the last sample."""
    step = simulation.control_step
    return [i for i, event in enumerate(events) if first_sample(event.time, step) > simulation.steps]
