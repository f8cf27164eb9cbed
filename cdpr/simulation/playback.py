"""Playback of a scenario's external commands, sample by sample."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence

from cdpr.scenario.events import ScenarioEvent, end_of_commands, first_sample
from cdpr.scenario.events.commands import Kind, overlay
from cdpr.simulation.external_command import Command
from cdpr.simulation.pipeline import Pipeline

Chosen = Callable[[Kind], Command]


class Playback:
    """Recorded commands by sample until a stop; `command` returns the replacement of the answer."""

    def __init__(self, events: Sequence[ScenarioEvent], step: float, command: Chosen) -> None:
        spans = overlay([], [])
        for commands in filter(None, (event.commands() for event in events)):
            spans = overlay(spans, commands)
        self._spans = [(first_sample(span.start, step), first_sample(span.end, step), span) for span in spans]
        self._command, self._end = command, end_of_commands(events, step)

    def __bool__(self) -> bool:
        return bool(self._spans)

    def at(self, k: int) -> Pipeline | None:
        """Return the pipeline for sample k; None if the controller decides it."""
        i = bisect_right(self._spans, k, key=lambda row: row[0]) - 1
        if i < 0 or k >= min(self._spans[i][1], self._end):
            return None
        span = self._spans[i][2]
        command = self._command(span.kind)
        command.values[:] = span.values
        return command.pipeline
