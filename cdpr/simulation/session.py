"""What is done to a simulation from outside, as events with their times, so that it can be repeated."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError

from cdpr.errors import CdprError, OutputError
from cdpr.log.event import Event
from cdpr.log.files import replace
from cdpr.problems import dotted
from cdpr.scenario import Scenario, load_scenario
from cdpr.scenario.events import MAX_EVENTS, ScenarioEvent, first_sample
from cdpr.scenario.events.commands import Span, overlay, written
from cdpr.scenario.events.outside import Outside
from cdpr.scenario.events.stop import EmergencyStop
from cdpr.scenario.messages import explain
from cdpr.scenario.overrides import plain_value
from cdpr.simulation.record import Block, Record

E = TypeVar("E", bound=ScenarioEvent)

DIGITS = 12  # of the times that are written: first_sample takes what differs by less than 1e-9 of itself for equal


Done = tuple[tuple[ScenarioEvent, ...], Block | None]


class Session:
    """A scenario, and what was done to its simulation so far.

    Attributes:
        scenario: as it was at the start.
        live: the events that were done since.
        record: the commands from outside.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.live: tuple[ScenarioEvent, ...] = ()
        self.record = Record()

    def __bool__(self) -> bool:
        """Whether anything was done."""
        return bool(self.live) or self.record.complete() is not None

    @property
    def events(self) -> tuple[ScenarioEvent, ...]:
        """The scenario's events, and those that were done."""
        return (*self.scenario.events, *self.live)

    def snapshot(self) -> Done:
        """Return what was done so far."""
        return self.live, self.record.complete()

    def restore(self, done: Done) -> None:
        """Forget what was done since a snapshot."""
        self.live, block = done
        self.record.restore(block)

    def make(self, title: str, kind: type[E], k: int, keys: Mapping[str, Any]) -> E:
        """Return an event at sample k, checked as those of the scenario are; nothing is done yet.

        Keys that are None are left out. Raises CdprError, which begins with the `title` of what the user asked for.
        """
        if len(self.events) >= MAX_EVENTS - (kind is not EmergencyStop):
            kept = "" if kind is EmergencyStop else ", of which the last is kept for a stop"
            raise CdprError(f"{title}: a scenario holds {MAX_EVENTS} events at most{kept}, and so many there are")
        try:
            data: dict[str, Any] = {key: plain_value(value) for key, value in keys.items() if value is not None}
            data = {"type": kind.kind(), **data, "time": self._time(k)}
            event = kind.model_validate_json(json.dumps(data))
        except ValidationError as error:
            told = [f"{dotted(one.path)}: {one.text}" if one.path else one.text for one in explain(error, kind, data)]
            raise CdprError(f"{title}: {'; '.join(told)}") from None
        except ValueError as error:
            raise CdprError(f"{title}: {error}") from None
        names = [cable.name for cable in self.scenario.robot.cables]
        if text := event.check_cable(names):
            raise CdprError(f"{title}: cable: {text}")
        event = event.named(names)
        self.check(title, (*self.live, event), event)
        return event

    def check(self, title: str, live: Sequence[ScenarioEvent], event: ScenarioEvent) -> None:
        """Raise CdprError where a new `event`, one of those `live`, cannot be, or another one after it no more."""
        events = [one for one in (*self.scenario.events, *live) if one is event or _concerns_others(type(one))]
        told = []
        for problem in self.scenario.problems_with(events, event):
            other, key = events[int(problem.path[1])], dotted(problem.path[2:])
            text = f"{key}: {problem.text}" if key else problem.text
            if other is not event:
                text = f"event '{other.type}' at {other.time:g} s could not happen then: {text}"
            told.append(text)
        if told:
            raise CdprError(f"{title}: {'; '.join(told)}")

    def released(self, event: ScenarioEvent, k: int) -> ScenarioEvent | None:
        """Return a wrench that ends at sample k; None for one that has not acted. CdprError where it cannot."""
        step = self.scenario.simulation.control_step
        known = isinstance(event, ScenarioEvent) and any(event is one for one in self.live)
        swing = event.swing(step) if known else None
        if swing is None:
            raise CdprError("release: what `push` returned is expected, and not yet released in this branch")
        if swing.end <= k:
            raise CdprError(f"release: that wrench has ended at {swing.end * step:g} s")
        if swing.first == k:
            return None
        return event.model_copy(update={"duration": _tidy(k * step - event.time)})

    def told(self, samples: int) -> Iterator[Event]:
        """Yield what was given within so many samples, an event for each uninterrupted span of one kind."""
        step = self.scenario.simulation.control_step
        rows: list[tuple[str, int, int]] = []
        for span in self._spans(samples):
            first, stop = first_sample(span.start, step), min(first_sample(span.end, step), samples)
            if rows and rows[-1][0] == span.kind and rows[-1][2] == first:
                first = rows.pop()[1]
            if first < stop:
                rows.append((span.kind, first, stop))
        for kind, first, stop in rows:
            text = f"the {kind} was given from outside ({stop - first} samples)"
            yield Event(first * step, Outside.kind(), text, until=stop * step)

    def save(self, path: Path, samples: int) -> None:
        """Write a scenario that repeats so many samples, and a table of what was given beside it.

        A table of that name is written over only where the scenario in that place names it: they go together. Raises
        CdprError where the scenario would not load, and OutputError where it cannot be written.
        """
        if path.suffix not in (".yaml", ".yml"):
            raise OutputError(f"{path}: a name that ends in .yaml is expected")
        if path.exists() and os.path.exists(self.scenario.source) and path.samefile(self.scenario.source):
            raise OutputError(f"{path}: is the scenario that is simulated; choose another name")
        step = self.scenario.simulation.control_step
        events = [event for event in self.events if not event.commands()]
        spans = self._spans(samples)
        if spans:
            table = table_beside(path)
            _put(table, written(spans, [cable.name for cable in self.scenario.robot.cables]), path)
            events.append(Outside.model_validate({"type": Outside.kind(), "file": table.name}))
        duration = _tidy(max(samples - 1, 1) * step)
        text = self.scenario.session_yaml(os.path.abspath(path.parent), events, duration)
        load_scenario(path, text=text, plugins=self.scenario.plugins)
        replace(path, text)

    def _time(self, k: int) -> float:
        """Time (s) of what is done at sample k: not before what the events let happen there."""
        step, events = self.scenario.simulation.control_step, self.events
        now = _tidy(k * step)
        acting = [event for event in events if type(event).actions is not ScenarioEvent.actions]
        there = [time for event in acting for time, _ in event.actions(step)] + [event.time for event in events]
        return max([now, *(time for time in there if time > now and first_sample(time, step) == k)])

    def _spans(self, samples: int) -> list[Span]:
        """Return what was given, by the scenario and since, within so many samples."""
        step, last = self.scenario.simulation.control_step, self.scenario.simulation.steps
        since, block = [], self.record.complete()
        while block is not None:
            for first, count, *values in block.rows:
                if first < samples:
                    stop = first + count
                    end = min(stop if stop < last else last + 1, samples)  # with the last step its sample is decided
                    since.append(Span(block.kind, _tidy(first * step), _tidy(end * step), np.array(values)))
            block = block.before
        spans: list[Span] = []
        for event in self.scenario.events:
            spans = overlay(spans, event.commands())
        return overlay(spans, since)


@cache
def _concerns_others(kind: type[ScenarioEvent]) -> bool:
    """Whether another event may be impossible for one of this kind, or this for another; no wrench is, nor are many."""
    checks = ("follow", "settle", "check_options")
    return any(getattr(kind, name) is not getattr(ScenarioEvent, name) for name in checks)


def _put(table: Path, text: str, path: Path) -> None:
    """Write the table of a scenario that is to be `path`; OutputError where another file has its place."""
    if table.is_file() and table.read_bytes() == text.encode():
        return
    if os.path.lexists(table) and not (path.is_file() and table.name.encode() in path.read_bytes()):
        raise OutputError(
            f"{table}: is there already, and is not the table of a session {path.name}: it is not written over; "
            "choose another name, or move it away"
        )
    replace(table, text)


def table_beside(path: Path) -> Path:
    """Return where a scenario that is saved as `path` has what was given from outside."""
    return path.with_name(f"{path.stem}_outside.csv")


def _tidy(time: float) -> float:
    """A time (s) without the round-off of a multiplication."""
    return float(f"{time:.{DIGITS}g}")
