"""Tension limits over time, as changed by a scenario's events."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from cdpr.log.limit_violations import LimitChanges
from cdpr.model import Robot
from cdpr.scenario.events.event import Action, ScenarioEvent, first_sample
from cdpr.sensing.disturbance import Disturbance


class Limits:
    """Receiver of event actions (a `EventActions`) that tracks only the tension limits (N)."""

    def __init__(self, robot: Robot) -> None:
        self._at = {cable.name: i for i, cable in enumerate(robot.cables)}
        self.low, self.high = robot.tension_min.tolist(), robot.tension_max.tolist()

    def limit(self, cable: str | None, low: float | None, high: float | None) -> None:
        """Change the limits of one cable or of all."""
        for i in range(len(self.low)) if cable is None else (self._at[cable],):
            self.low[i] = self.low[i] if low is None else low
            self.high[i] = self.high[i] if high is None else high

    def cut_power(self) -> None:
        """Remove the lowest tensions: without power, slack is allowed."""
        self.low = [-math.inf] * len(self.low)

    def hold(self, cable: str, tension: float | None) -> None:
        """Do nothing: broken and jammed cables keep their limits."""

    def lock(self, cable: str) -> None:
        """Do nothing: detection changes no limit."""

    def set(self, key: str, value: Any) -> None:
        """Do nothing: options change no limit."""

    def disturb(self, sensor: str, change: Disturbance) -> None:
        """Do nothing: sensors change no limit."""


def limit_changes(events: Sequence[ScenarioEvent], robot: Robot, step: float) -> LimitChanges:
    """Return the tension limits after each change, in order of time; `step` is the control period, s."""
    actions: list[tuple[int, Action]] = []
    for event in events:
        actions += [(first_sample(time, step), do) for time, do in event.actions(step)]
    limits, found = Limits(robot), dict[int, tuple[tuple[float, ...], tuple[float, ...]]]()
    before = tuple(limits.low), tuple(limits.high)
    for k, do in sorted(actions, key=lambda row: row[0]):
        do(limits)
        now = tuple(limits.low), tuple(limits.high)
        if now != before:
            found[k], before = now, now
    return tuple(
        (k * step, tuple(None if math.isinf(value) else value for value in low), high)
        for k, (low, high) in found.items()
    )
