"""Does in the loop what a scenario's events say. (What is told of them afterwards is in `events`.)"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.scenario.event_schema import (
    CableBreak,
    CableFault,
    EmergencyStop,
    Load,
    ScenarioEvent,
    Sine,
    TensionLimits,
    first_sample,
)
from cdpr.tension.command import CommandStage
from cdpr.tension.stage import TensionStage
from cdpr.trajectory import Stopping, Trajectory

NEVER = -1  # no sample has this number

Action = Callable[[], None]


class Schedule:
    """Changes the plant and the tension stage at the samples at which something happens.

    A fault acts on the plant through the tension that the stage imposes after it has distributed; the distribution
    learns of it by limits that lock the cable. tension (m,), wrench (6,), status (1,) and external (6,) are those of
    the present row, `push` (6,) is the backend's external wrench.

    Attributes:
        distribute: what the loop calls in place of the stage's own, which it is where no event touches a cable.
    """

    def __init__(
        self,
        events: Sequence[ScenarioEvent],
        step: float,
        robot: Robot,
        stage: TensionStage | CommandStage,
        tension: Array,
        wrench: Array,
        status: Array,
        external: Array,
        push: Array,
    ) -> None:
        self._stage = stage
        self._tension, self._wrench, self._status, self._external, self._push = tension, wrench, status, external, push
        self._limits = stage.limits.copy()
        self._locked = np.zeros(robot.m, dtype=bool)  # cables that the distribution knows to be held
        self._cables = {cable.name: slice(i, i + 1) for i, cable in enumerate(robot.cables)}
        self._loads = np.array([_load(event, step) for event in events if isinstance(event, Load)]).reshape(-1, 10)
        todo = [(time, do) for event in events for time, do in self._actions(event, step)]
        self._todo: dict[int, list[Action]] = {}
        for time, do in sorted(todo, key=lambda row: row[0]):
            self._todo.setdefault(first_sample(time, step), []).append(do)
        changes = self._loads[:, :2].ravel()
        self._due = sorted({*self._todo, *(int(k) for k in changes[np.isfinite(changes)])})
        touched = any(isinstance(event, CableFault | EmergencyStop) for event in events)
        self.distribute = self._distribute if touched else stage.distribute

    def begin(self) -> int:
        """Put everything back; return the sample at which `act` is due, or NEVER."""
        self._imposing, self._power = False, True
        self._stage.limits[:] = self._limits
        self._stage.held[:] = np.nan
        self._locked[:] = False
        if len(self._loads):
            self._push[:] = 0.0
        self._external[:] = self._push
        return self._due[0] if self._due else NEVER

    def warm_up(self) -> None:
        """Call what only events need, so that it does not compile in the loop."""
        if self._due:
            self._stage.impose()
            write_loads(self._loads, 0, self._external)

    def act(self, k: int) -> int:
        """Let happen what is due at sample k, before it is computed; return the sample that is due next."""
        for do in self._todo.get(k, ()):
            do()
        swinging = False
        if len(self._loads):
            swinging = write_loads(self._loads, k, self._external)
            self._push[:] = self._external
        if swinging:
            return k + 1
        following = bisect_right(self._due, k)
        return self._due[following] if following < len(self._due) else NEVER

    def _actions(self, event: ScenarioEvent, step: float) -> Iterator[tuple[float, Action]]:
        """Yield what an event does to cables, and when, s."""
        if isinstance(event, CableFault):
            cable = self._cables[str(event.cable)]
            yield event.time, partial(self._hold, cable, 0.0 if isinstance(event, CableBreak) else None)
            yield event.time + event.detected_after, partial(self._lock, cable)
        elif isinstance(event, TensionLimits):
            cable = slice(None) if event.cable is None else self._cables[str(event.cable)]
            yield event.time, partial(self._limit, cable, event.min, event.max)
        elif isinstance(event, EmergencyStop) and event.category != 2:
            yield power_off(event, step), self._cut

    def _hold(self, cable: slice, tension: float | None) -> None:
        """From now on a cable has this tension (N), where None is given that of the sample before."""
        self._stage.held[cable] = self._tension[cable] if tension is None else tension
        self._imposing = True

    def _lock(self, cable: slice) -> None:
        """The distribution learns which tension a cable is held at."""
        self._stage.limits[:, cable] = self._stage.held[cable]
        self._locked[cable] = True

    def _limit(self, cable: slice, low: float | None, high: float | None) -> None:
        free = ~self._locked[cable]
        for row, value in zip(self._stage.limits[:, cable], (low, high), strict=True):
            if value is not None:
                row[free] = value

    def _cut(self) -> None:
        """The power fails: only jammed cables keep their tension."""
        held = self._stage.held
        held[np.isnan(held)] = 0.0
        self._power, self._imposing = False, True

    def _distribute(self) -> None:
        if self._power:
            self._stage.distribute()
        else:  # nothing is asked of the cables any more
            self._wrench[:] = self._status[:] = 0.0
        if self._imposing:
            self._stage.impose()


def stopped(motion: Trajectory, events: Sequence[ScenarioEvent], step: float) -> Trajectory:
    """Return the motion with the controlled emergency stop that `events` hold, if any."""
    for event in events:
        if isinstance(event, EmergencyStop) and event.category != 0:
            return Stopping(motion, first_sample(event.time, step) * step, event.stopping_time)
    return motion


def power_off(event: EmergencyStop, step: float) -> float:
    """Time, s, at which a stop of category 0 or 1 cuts the power."""
    return event.time if event.category == 0 else first_sample(event.time, step) * step + event.stopping_time


def _load(event: Load, step: float) -> list[float]:
    """One row for `write_loads`."""
    first = first_sample(event.time, step)
    end = math.inf if event.duration is None else float(first_sample(event.time + event.duration, step))
    swing = (2.0 * math.pi * event.frequency * step, event.phase) if isinstance(event, Sine) else (0.0, 0.5 * math.pi)
    return [float(first), end, *swing, *event.force, *event.moment]


@kernel
def write_loads(loads: Array, k: int, external: Array) -> bool:
    """Write the wrench (6,) at sample k and return whether it will be another one at the next.

    Rows of `loads`: first sample, sample at which it has ended, angle per sample and first angle of the sine that the
    amplitude is multiplied by (rad; a quarter turn for what does not swing), amplitude (6).
    """
    swinging = False
    for j in range(6):
        external[j] = 0.0
    for i in range(loads.shape[0]):
        if loads[i, 0] <= k < loads[i, 1]:
            swinging = swinging or loads[i, 2] > 0.0
            part = math.sin(loads[i, 3] + (k - loads[i, 0]) * loads[i, 2])
            for j in range(6):
                external[j] += part * loads[i, 4 + j]
    return swinging
