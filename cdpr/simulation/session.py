"""Session: the external commands of a simulation as events with times, so that it can be repeated."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError

from cdpr.base.errors import CdprError, OutputError
from cdpr.base.problems import dotted, first_ones
from cdpr.config.messages import explain
from cdpr.config.overrides import plain_value
from cdpr.log.event import Event
from cdpr.log.files import replace
from cdpr.scenario import Scenario, load_scenario
from cdpr.scenario.events import MAX_EVENTS, ScenarioEvent, end_of_commands, first_sample
from cdpr.scenario.events.commands import Span, overlay, written
from cdpr.scenario.events.event import AttachmentSpan, WrenchProfile
from cdpr.scenario.events.external_command import ExternalCommand
from cdpr.scenario.events.stop import EmergencyStop
from cdpr.simulation.record import Block, Record

E = TypeVar("E", bound=ScenarioEvent)

DIGITS = 12  # of the written times: first_sample treats relative differences below 1e-9 as equal


Done = tuple[tuple[ScenarioEvent, ...], Block | None]


class Session:
    """Scenario with the live events and commands of its simulation.

    Attributes:
        scenario: scenario at the start.
        live: live events since then.
        record: external commands.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.live: tuple[ScenarioEvent, ...] = ()
        self.record = Record()

    def __bool__(self) -> bool:
        """Return whether there are live events or commands."""
        return bool(self.live) or self.record.complete() is not None

    @property
    def events(self) -> tuple[ScenarioEvent, ...]:
        """Return the events of the scenario, and the live ones."""
        return (*self.scenario.events, *self.live)

    def snapshot(self) -> Done:
        """Return a snapshot of events and commands."""
        return self.live, self.record.complete()

    def restore(self, done: Done) -> None:
        """Restore a snapshot."""
        self.live, block = done
        self.record.restore(block)

    def make(self, title: str, kind: type[E], k: int, keys: Mapping[str, Any]) -> E:
        """Return an event at sample k, checked like those of the scenario, without applying it.

        Keys with the value None are omitted.

        Raises:
            CdprError: if it is invalid; the message begins with the `title` of the request.
        """
        if len(self.events) >= MAX_EVENTS - (kind is not EmergencyStop):
            kept = "" if kind is EmergencyStop else ", of which the last is kept for a stop"
            raise CdprError(f"{title}: a scenario holds {MAX_EVENTS} events at most{kept}, which already exist")
        try:
            data: dict[str, Any] = {key: plain_value(value) for key, value in keys.items() if value is not None}
            data = {"type": kind.kind(), **data, "time": self._time(k)}
            event = kind.model_validate_json(json.dumps(data))
        except ValidationError as error:
            texts = [f"{dotted(one.path)}: {one.text}" if one.path else one.text for one in explain(error, kind, data)]
            raise CdprError(f"{title}: {'; '.join(first_ones(texts))}") from None
        except ValueError as error:
            raise CdprError(f"{title}: {error}") from None
        names = [cable.name for cable in self.scenario.robot.cables]
        if text := event.check_cable(names):
            raise CdprError(f"{title}: cable: {text}")
        event = event.named(names)
        self.check(title, (*self.live, event), event)
        return event

    def check(self, title: str, live: Sequence[ScenarioEvent], event: ScenarioEvent) -> None:
        """Check a new `event`, one of `live`.

        Raises:
            CdprError: if the event or a later one is impossible.
        """
        events = [one for one in (*self.scenario.events, *live) if one is event or _concerns_others(type(one))]
        texts = []
        for problem in self.scenario.problems_with(events, event):
            other, key = events[int(problem.path[1])], dotted(problem.path[2:])
            text = f"{key}: {problem.text}" if key else problem.text
            if other is not event:
                text = f"event '{other.type}' at {other.time:g} s could not happen then: {text}"
            texts.append(text)
        if texts:
            raise CdprError(f"{title}: {'; '.join(first_ones(texts))}")

    def released(self, event: ScenarioEvent, k: int, *, undo: bool) -> ScenarioEvent | None:
        """Return a wrench or an attached body that ends at sample k; None if it has not acted.

        Args:
            event: live event.
            k: number of the sample.
            undo: True if a body attached at this sample can be removed, as if it had never been there.

        Raises:
            CdprError: if it cannot end then.
        """
        step = self.scenario.simulation.control_step
        known = isinstance(event, ScenarioEvent) and any(event is one for one in self.live)
        span = acting_span(event, step) if known else None
        if span is None:
            given = "a value that `push` or `attach` returned"
            raise CdprError(f"release: expected {given}, not yet released in this branch")
        if span.end <= k:
            raise CdprError(f"release: that {event.type} has ended at {span.end * step:g} s")
        if span.first == k:
            if isinstance(span, AttachmentSpan) and not undo:  # to attach and detach it rounds the state of a plant
                raise CdprError(f"release: the {event.type} was attached at the present sample: take a step first")
            return None
        return event.model_copy(update={"duration": _tidy(k * step - event.time)})

    def command_events(self, samples: int) -> Iterator[Event]:
        """Yield an event for each uninterrupted span of one kind of command within these samples."""
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
            yield Event(first * step, ExternalCommand.kind(), text, until=stop * step)

    def save(self, path: Path, samples: int) -> None:
        """Write a scenario that repeats these samples, and a table of the commands beside it.

        An existing table is overwritten only if the existing scenario refers to it.

        Raises:
            CdprError: if the scenario would not load.
            OutputError: if a file cannot be written.
        """
        if path.suffix not in (".yaml", ".yml"):
            raise OutputError(f"{path}: expected a name that ends in .yaml")
        if path.exists() and os.path.exists(self.scenario.source) and path.samefile(self.scenario.source):
            raise OutputError(f"{path}: is the scenario that is simulated; choose another name")
        step = self.scenario.simulation.control_step
        events = [event for event in self.events if not event.commands()]
        spans = self._spans(samples)
        if spans:
            table = table_beside(path)
            _put(table, written(spans, [cable.name for cable in self.scenario.robot.cables]), path)
            events.append(ExternalCommand.model_validate({"type": ExternalCommand.kind(), "file": table.name}))
        duration = _tidy(max(samples - 1, 1) * step)
        text = self.scenario.session_yaml(os.path.abspath(path.parent), events, duration)
        load_scenario(path, text=text, plugins=self.scenario.plugins)
        replace(path, text)

    def _time(self, k: int) -> float:
        """Return the time (s) of an event at sample k, not before the earliest time that the events allow."""
        step, events = self.scenario.simulation.control_step, self.events
        now = _tidy(k * step)
        acting = [event for event in events if type(event).actions is not ScenarioEvent.actions]
        there = [time for event in acting for time, _ in event.actions(step)] + [event.time for event in events]
        return max([now, *(time for time in there if time > now and first_sample(time, step) == k)])

    def _spans(self, samples: int) -> list[Span]:
        """Return the commands of the scenario and the live ones within these samples, before a stop."""
        step, last = self.scenario.simulation.control_step, self.scenario.simulation.steps
        since, block = [], self.record.complete()
        while block is not None:
            for first, count, *values in block.rows:
                if first < samples:
                    stop = first + count
                    end = min(stop if stop < last else last + 1, samples)  # the last step also decides its sample
                    since.append(Span(block.kind, _tidy(first * step), _tidy(end * step), np.array(values)))
            block = block.before
        spans: list[Span] = []
        for event in self.scenario.events:
            spans = overlay(spans, event.commands())
        spans, end = overlay(spans, since), end_of_commands(self.events, step)
        within = [span for span in spans if first_sample(span.start, step) < end]
        return [
            span if first_sample(span.end, step) <= end else dataclasses.replace(span, end=_tidy(end * step))
            for span in within
        ]


def acting_span(event: ScenarioEvent, step: float) -> WrenchProfile | AttachmentSpan | None:
    """Return the samples at which a wrench or an attached body of an event acts; None for other events."""
    return event.wrench_profile(step) or event.attachment(step)


@cache
def _concerns_others(kind: type[ScenarioEvent]) -> bool:
    """Return whether an event of this kind can conflict with another one; wrenches and some others cannot."""
    checks = ("follow", "settle", "check_options")
    return any(getattr(kind, name) is not getattr(ScenarioEvent, name) for name in checks)


def _put(table: Path, text: str, path: Path) -> None:
    """Write the table of a scenario that becomes `path`.

    Raises:
        OutputError: if another file has its name.
    """
    if table.is_file() and table.read_bytes() == text.encode():
        return
    if os.path.lexists(table) and not (path.is_file() and table.name.encode() in path.read_bytes()):
        raise OutputError(
            f"{table}: exists already, and is not the table of a session {path.name}: it is not overwritten; "
            "choose another name, or move it away"
        )
    replace(table, text)


def table_beside(path: Path) -> Path:
    """Return the path of the table for a scenario saved as `path`."""
    return path.with_name(f"{path.stem}_outside.csv")


def _tidy(time: float) -> float:
    """Return a time (s) without the round-off of a multiplication."""
    return float(f"{time:.{DIGITS}g}")
