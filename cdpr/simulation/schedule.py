"""Execution of a scenario's events in the loop; `events` reports them afterwards."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.scenario.events import ScenarioEvent, first_sample
from cdpr.sensing.disturbance import Disturbance
from cdpr.simulation.attached import AttachedBodies
from cdpr.simulation.brakes import Brakes
from cdpr.simulation.loads import Loads
from cdpr.simulation.settings import Settings
from cdpr.tension.command import CommandStage
from cdpr.tension.operations import Operation, perform
from cdpr.tension.stage import TensionStage

NEVER = -1  # no sample has this number

Action = Callable[[], None]
Disturb = Callable[[str, Disturbance], None]
Does = tuple[ScenarioEvent, tuple[float, ...] | None, list[tuple[float, Action]]]


class Schedule:
    """Changes of the plant and the tension stage by events, at their samples.

    A fault acts on the plant through the tension that the stage imposes after it has distributed. The distribution
    receives it as limits that lock the cable.

    Args:
        events: events of the run.
        step: control period, s.
        robot: robot with the cables of the events.
        stage: tension stage; its live arrays are those of the present sample.
        loads: external wrenches.
        settings: options that events may change; None without a controller.
        attached: bodies on the platform.
        locked: (m,), True for cables that the distribution has locked; written.
        applied: (m,), N, tensions that drives apply to ideal cables; by default those of the stage.
        brakes: brakes of the winches.
        disturb: function that disturbs a sensor.
    """

    def __init__(
        self,
        events: Sequence[ScenarioEvent],
        step: float,
        robot: Robot,
        stage: TensionStage | CommandStage,
        loads: Loads,
        settings: Settings | None = None,
        attached: AttachedBodies | None = None,
        locked: NDArray[np.bool_] | None = None,
        applied: Array | None = None,
        brakes: Brakes | None = None,
        disturb: Disturb | None = None,
    ) -> None:
        self._stage, self._step, self._brakes = stage, step, brakes
        self._applied = stage.live.tension if applied is None else applied
        self._settings, self._attached, self._disturb = settings, attached, disturb
        self._loads = loads
        self._first = stage.cables.copy()
        self._locked = np.zeros(robot.m, dtype=bool) if locked is None else locked
        self._cables = {cable.name: slice(i, i + 1) for i, cable in enumerate(robot.cables)}
        self._swings = np.zeros((0, 10))
        self._does: dict[int, Does] = {}
        self._todo: dict[int, list[Action]]
        self._imposing, self._power = False, True  # whether cables are held, and whether a tension is imposed on any
        self.plan(events)

    def plan(self, events: Sequence[ScenarioEvent]) -> None:
        """Replace the events; past ones are not repeated."""
        step = self._step
        # Each event is evaluated once: with hundreds of live events the plan is renewed as often.
        known = self._does
        self._does = {id(event): known.get(id(event)) or self._what(event) for event in events}
        does = self._does.values()
        rows = [swing for _, swing, _ in does if swing is not None]
        acted, self._swings = len(self._swings) > 0, np.array(rows, dtype=float).reshape(-1, 10)
        self._write_loads = self._loads.writing(self._swings)
        if acted and not rows:
            self._loads.plant[:] = self._loads.row[:] = 0.0
        todo = [action for _, _, actions in does for action in actions]
        self._todo = {}
        for time, do in sorted(todo, key=lambda row: row[0]):
            self._todo.setdefault(first_sample(time, step), []).append(do)
        changes = self._swings[:, :2]
        loading = () if self._attached is None else self._attached.plan(events, step)
        self._due = sorted({*self._todo, *map(int, changes[np.isfinite(changes)]), *loading})
        self._overrides = any(event.overrides for event in events)
        self._through = self.through(self._stage)

    def _what(self, event: ScenarioEvent) -> Does:
        """Return an event (kept alive, identified by its id), its wrench, and its actions."""
        swing = event.wrench_profile(self._step)
        row = None if swing is None else (swing.first, swing.end, swing.angle, swing.phase, *swing.amplitude)
        return event, row, list(self._actions(event))

    def _actions(self, event: ScenarioEvent) -> Iterator[tuple[float, Action]]:
        """Yield the actions of an event with their times, s; brakes close after a power cut."""
        for time, do in event.actions(self._step):
            yield time, partial(do, self)
            if event.cuts_power and self._brakes is not None:
                yield from self._brakes.closing(time)

    def distribute(self) -> None:
        """Distribute by the stage, with the effects of events."""
        perform(self._through)

    def through(self, stage: TensionStage | CommandStage) -> list[Operation]:
        """Return the operations that distribute by this stage: the stage's own, if no event concerns a cable."""
        if not self._overrides:
            return list(stage.operations)
        unasked = bind("power_off", wrench=stage.live.wrench, status=stage.live.status)
        return [
            *(each._replace(when=lambda: self._power) for each in stage.operations),
            Operation("distribution", unasked, when=lambda: not self._power),
            *(each._replace(when=lambda: self._imposing) for each in stage.imposing),
        ]

    def snapshot(self, k: int) -> object:
        """Return the effects so far on cables, power and options, and those of sample k on the mass."""
        attached = {} if self._attached is None else self._attached.snapshot(k)
        settings = None if self._settings is None else self._settings.snapshot()
        return self._imposing, self._power, self._stage.cables.copy(), self._locked.copy(), settings, attached

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot."""
        self._imposing, self._power, cables, self._locked[:], settings, attached = snapshot
        if self._attached is not None:
            self._attached.restore(attached)
        self._stage.cables.put(cables)
        if self._settings is not None:
            self._settings.restore(settings)

    def begin(self) -> int:
        """Reset everything; return the sample at which `apply` is due, or NEVER."""
        self._imposing, self._power = False, True
        self._stage.cables.put(self._first)
        self._locked[:] = False
        if self._settings is not None:
            self._settings.reset()
        if len(self._swings):
            self._loads.plant[:] = 0.0
        self._loads.row[:] = self._loads.plant
        if self._attached is not None:
            self._attached.reset()
        return self._due[0] if self._due else NEVER

    def warm_up(self) -> None:
        """Call once the functions that only events need."""
        if self._due:
            self._stage.impose()
            self._write_loads(0)

    def apply(self, k: int) -> int:
        """Apply the events due at sample k, before it is computed; return the next sample that is due."""
        for do in self._todo.get(k, ()):
            do()
        return self.push(k)

    def join(self, event: ScenarioEvent, k: int) -> None:
        """Apply at sample k an event that was added after the other events of that sample."""
        for time, do in sorted(self._actions(event), key=lambda row: row[0]):
            if first_sample(time, self._step) == k:
                do()

    def can_undo(self, k: int) -> bool:
        """Return True if a body attached at sample k can be removed at this sample, as if it had never been there."""
        return self._attached is not None and self._attached.can_undo(k)

    def load(self, k: int) -> None:
        """Attach the bodies of sample k to the platform."""
        if self._attached is not None:
            self._attached.update(k)

    def push(self, k: int) -> int:
        """Apply the external wrench and the bodies of sample k; return the next sample that is due."""
        self.load(k)
        swinging = False
        if len(self._swings):
            swinging = self._write_loads(k)
            self._loads.plant[:] = self._loads.row
        if swinging:
            return k + 1
        following = bisect_right(self._due, k)
        return self._due[following] if following < len(self._due) else NEVER

    def hold(self, cable: str, tension: float | None) -> None:
        """Hold a cable at this tension (N) from now on, by default at that of the previous sample."""
        at = self._cables[cable]
        self._stage.cables.held[at] = self._applied[at] if tension is None else tension
        self._imposing = True

    def lock(self, cable: str) -> None:
        """Lock a cable in the distribution, at its held tension."""
        at = self._cables[cable]
        self._stage.cables.limits[:, at] = self._stage.cables.held[at]
        self._locked[at] = True

    def limit(self, cable: str | None, low: float | None, high: float | None) -> None:
        """Change the limits (N) of one cable or all, except those that the distribution has locked."""
        at = slice(None) if cable is None else self._cables[cable]
        cables, free = self._stage.cables, ~self._locked[at]
        for limits in (cables.limits, cables.true_limits):
            for row, value in zip(limits[:, at], (low, high), strict=True):
                if value is not None:
                    row[free] = value

    def cut_power(self) -> None:
        """Cut the power: only jammed cables and those with a brake keep their tension."""
        held = self._stage.cables.held
        held[np.isnan(held)] = 0.0
        self._power, self._imposing = False, True
        if self._brakes is not None:
            self._brakes.cut()

    def set(self, key: str, value: Any) -> None:
        """Change an option of a plugin, if there are plugins."""
        if self._settings is not None:
            self._settings.set(key, value)

    def disturb(self, sensor: str, change: Disturbance) -> None:
        """Disturb a sensor, if the loop has sensors."""
        if self._disturb is not None:
            self._disturb(sensor, change)
