"""Validation of events: existing cables, and a consistent order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

from pydantic import ValidationError

from cdpr.base.problems import Path, dotted
from cdpr.cables import COMMANDED, TENSION, composed
from cdpr.cables.brake import TORQUE as BRAKE
from cdpr.cables.chain import DIAMETER
from cdpr.config.document import Document
from cdpr.config.problems import Problems
from cdpr.scenario.changes import Options
from cdpr.scenario.checks import Checks
from cdpr.scenario.events import EVENTS, ScenarioEvent, first_sample
from cdpr.scenario.events.event import History
from cdpr.scenario.initial import Initial
from cdpr.scenario.limits_schema import TensionSection, limits
from cdpr.scenario.motions.guide import Guide
from cdpr.scenario.report import SectionReport
from cdpr.scenario.robot_schema import CableSection, CablesSection, cable_name
from cdpr.scenario.schema import Simulation
from cdpr.scenario.winch_kinds import command_of, kind_of, winch_path
from cdpr.sensing import SENSORS, Sensor

Places = list[tuple[int, ScenarioEvent]]  # with the index in the file


class EventChecks(Checks):
    """Checks of the events that are valid on their own; `options` are those of the plugins, if known."""

    def __init__(self, document: Document, problems: Problems, options: Options | None = None) -> None:
        super().__init__(document, problems)
        self._options = options

    def run(
        self, given: Sequence[ScenarioEvent] | None = None, new: ScenarioEvent | None = None
    ) -> list[ScenarioEvent]:
        """Report all problems; return the valid events with their files loaded.

        Args:
            given: events to check; defaults to those of the document.
            new: the only one of them that has not been checked on its own.
        """
        events = self._read() if given is None else list(enumerate(given))
        if not events:
            return []
        unknown = events if new is None else [(i, event) for i, event in events if event is new]
        simulation = self.section(Simulation, ("simulation",))
        if simulation:
            for i, event in unknown:
                for key, text in event.check_steps(simulation.control_step):
                    self.add_problem(("events", i, key), text)
        self._against_guide(unknown)
        cables = list(self.cables(("robot",)))
        given = self.document.get(("robot", "cables"))
        if not isinstance(given, list) or len(cables) != len(given):
            return [event for _, event in events]  # names and limits are unknown
        names = [cable_name(cable, i) for i, cable in cables]
        known = [(i, event.named(names)) for i, event in events if self._cable_exists(i, event, names)]
        known.sort(key=lambda place: place[1].time)
        sensors = list(self._sensors())
        for i, event in unknown if None not in sensors else ():
            for key, text in event.check_sensor([each for each in sensors if each], len(cables)):
                self.add_problem(("events", i, key), text)
        if self._options is not None:
            for i, event in sorted(events, key=lambda place: place[1].time):
                for path, text in event.check_options(self._options):
                    if not self.problems.has(("events", i, *path)):  # a null has been reported
                        self.add_problem(("events", i, *path), text)
        self._need_ideal_cables(known)
        self._need_brakes(known)
        history = History(self.document.get(("robot", "unilateral")) is not False)
        history.cables = names
        if self.document.get(("robot", "cable", DIAMETER.key)) is None:
            history.thin = [name for name, (_, each) in zip(names, cables, strict=True) if _thin(each)]
        common = self.section(TensionSection, ("robot", "tension"))
        both = () if common is None else (common.min, common.max)
        if common and all(not isinstance(value, list) or len(value) == len(cables) for value in both):
            history.limits = {
                name: limits(common, cable.tension, i) for name, (i, cable) in zip(names, cables, strict=True)
            }
        for _, group in groupby(known, key=lambda place: place[1].time):
            together = list(group)
            for i, event in together:
                for text in event.follow(history):
                    self.add_problem(("events", i), text)
            for i, event in together:
                for text in event.settle(history):
                    self.add_problem(("events", i), text)
        return [event for _, event in events]

    def _read(self) -> Places:
        given = self.document.get(("events",))
        events: Places = []
        for i, item in enumerate(given if isinstance(given, list) else ()):
            try:
                event = EVENTS.read(item)
            except ValidationError:
                continue  # has been reported
            loaded = event.load(SectionReport(self, ("events", i)))
            if loaded is not None:
                events.append((i, loaded))
        return events

    def _against_guide(self, events: Places) -> None:
        """Report poses that the guide does not allow."""
        dof = self.directions(("robot", "dof"))
        initial = self.section(Initial, ("initial",))
        if dof and initial:
            guide = Guide(dof, initial.position, self.add_problem)
            for i, event in events:
                event.stay(guide, ("events", i))

    def _sensors(self) -> Iterator[Sensor | None]:
        """Yield the sensors; None for an invalid one."""
        given = self.document.get(("sensors",))
        for i, item in enumerate(given if isinstance(given, list) else ()):
            kind = item.get("type") if isinstance(item, dict) else None
            yield self.section(SENSORS[kind], ("sensors", i)) if isinstance(kind, str) and kind in SENSORS else None

    def _cable_exists(self, i: int, event: ScenarioEvent, names: Sequence[str]) -> bool:
        text = event.check_cable(names)
        if text:
            self.add_problem(("events", i, "cable"), text)
        return not text

    def _need_ideal_cables(self, events: Places) -> None:
        cables = self.document.get(("robot", "cables"))
        own: dict[Path, str] = {}
        for i, cable in enumerate(cables if isinstance(cables, list) else ()):
            kind = kind_of(self.document, ("robot",), cable)
            if kind is not None and not composed(*kind).immediate:
                given = cable.get("model") is not None
                own[("robot", "cables", i, "model") if given else ("robot", "cable", "model")] = kind[0]
        others = sorted(own, key=len)
        if self.document.get(("actuators",)) is not None:
            text = "applies to ideal cables only: remove this event, or `actuators`"
        elif others:
            ideal = f"remove it or set that to {COMMANDED}"
            text = f"happens to ideal cables only, and {dotted(others[0])} is {own[others[0]]}: {ideal}"
        elif rubbing := self._rubbing():
            text = f"happens to ideal cables only, and {rubbing} has friction: remove it or that"
        else:
            return
        for i, event in events:
            if event.ideal_cables_only:
                self.add_problem(("events", i, "type"), text)

    def _rubbing(self) -> str:
        """Return the key of an exit with friction; "" without one."""
        common = self.section(CablesSection, ("robot", "cable"))
        for i, cable in self.cables(("robot",)):
            leaves = cable.exit or (common.exit if common else None)
            if leaves is not None and leaves.rubs:
                return dotted(("robot", "cable", "exit") if cable.exit is None else ("robot", "cables", i, "exit"))
        return ""

    def _need_brakes(self, events: Places) -> None:
        """Report power cuts of winches that hold lengths without a brake."""
        cutting = [i for i, event in events if event.cuts_power]
        cables = self.document.get(("robot", "cables")) if cutting else ()
        for k, cable in enumerate(cables if isinstance(cables, list | tuple) else ()):
            kind = kind_of(self.document, ("robot",), cable)
            if kind is not None and command_of(kind) not in ("", TENSION):
                path = winch_path(("robot",), cable, k)
                if self.document.get((*path, BRAKE.key)) is not None:
                    continue
                where = dotted((*path, "type"))
                for i in cutting:
                    text = (
                        f"a power cut needs a brake of each winch that holds a length, and {where} is {kind[1]}: set "
                        f"{dotted((*path, BRAKE.key))} (N m), or category: 2"
                    )
                    self.add_problem(("events", i), text)
                return


def _thin(cable: CableSection) -> bool:
    """Return True if a cable has no diameter of its own."""
    return getattr(cable, DIAMETER.key) is None


def beyond(events: Sequence[ScenarioEvent], simulation: Simulation) -> list[int]:
    """Return the indices of the events after the last sample."""
    step = simulation.control_step
    return [i for i, event in enumerate(events) if first_sample(event.time, step) > simulation.steps]
