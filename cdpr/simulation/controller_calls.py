"""Calls of a controller at its own period, and its further inputs."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.errors import PluginError
from cdpr.base.problems import short_repr
from cdpr.model.arrays import checked
from cdpr.model.robot import Array, read_only
from cdpr.native.bind import bind
from cdpr.plugins import Controller, ControllerInputs, SnapshotOfArrays
from cdpr.scenario.events import ScenarioEvent, first_sample, redirected, redirecting
from cdpr.simulation.parts import Parts
from cdpr.tension.command import CommandStage
from cdpr.tension.operations import Operation
from cdpr.trajectory import Trajectory

if TYPE_CHECKING:
    from cdpr.simulation.sample import Sample
    from cdpr.tension.stage import TensionStage


def observes(controller: Controller) -> bool:
    """Return True if a controller uses `ControllerInputs`."""
    return isinstance(controller, Controller) and type(controller).observe is not Controller.observe


def corrects(controller: Controller) -> bool:
    """Return True if a controller has an inner loop on the distributed tensions."""
    return isinstance(controller, Controller) and type(controller).inner_loop is not Controller.inner_loop


def period_of(controller: Controller) -> int:
    """Return the number of control steps between two calls of a controller.

    Raises:
        PluginError: if it is not a whole number, at least 1.
    """
    period: Any = getattr(controller, "period", 1)
    if isinstance(period, bool) or not isinstance(period, int | np.integer) or period < 1:
        name = type(controller).__name__
        raise PluginError(
            f"{name}.period: expected a whole number of control steps, at least 1, got {short_repr(period)}"
        )
    return int(period)


def add_inner_loop(controller: Controller, stage: TensionStage, distributed: Array) -> None:
    """Let a stage send the tensions of the controller's inner loop, which then has `distributed` (m,) as its input."""
    tension = stage.live.tension
    correct = controller.inner_loop(read_only(distributed), tension)
    if correct is not None:
        before = bind("copy", source=distributed, target=tension)
        after = bind("copy", source=tension, target=distributed)
        stage.operations.insert(0, Operation("distribution", before))
        stage.operations += [Operation("distribution", after), Operation("controller", correct, timed=True)]


class ControllerCalls(SnapshotOfArrays):
    """Controller that is called every `period` control steps, with its output held in between.

    Args:
        parts: parts of the loop.
        present: present sample; `sent` receives the tensions as sent, if the controller or a part reads them.

    Attributes:
        period: number of control steps.
        arrays: state; () for controllers that are called in each control step, if nothing reads the sent tensions.
    """

    def __init__(self, parts: Parts, present: Sample) -> None:
        controller, self._now = parts.controller, present.view("time")
        self._controller = controller
        self._control, self._step = controller.control, parts.control_step
        self.period = period_of(controller)
        self.follow(parts.trajectory, parts.planned, parts.events)
        self._held = np.full(6 if parts.output == "wrench" else parts.robot.m, np.nan)
        self._called = np.zeros(1)  # 0 before the first call
        self._sent, self._distributed = present.sent, np.zeros(parts.robot.m)
        self._corrects = corrects(controller)
        self._records = observes(controller) or any(part.reads_commands for part in parts.more)
        self.arrays = (self._held, self._called, self._sent) if self._records or self.period > 1 else ()
        self.arrays += (self._distributed,) if self._corrects else ()
        if observes(controller):
            known, limits, sent = read_only(present.locked), read_only(present.cables.limits), read_only(self._sent)
            names = [column.name for part in parts.more if part.measures for column in part.columns]
            measured = {name: read_only(present.view(name)) for name in names}
            controller.observe(ControllerInputs(self.preview, limits, known, sent, MappingProxyType(measured)))

    def follow(self, motion: Trajectory, planned: Trajectory, events: Sequence[ScenarioEvent]) -> None:
        """Preview another motion: the `planned` one, which these events change to `motion`."""
        step, moving = self._step, redirecting(events)
        self._motion, self._changes = motion, [first_sample(event.time, step) for event in moving]
        self._after = lru_cache(maxsize=1)(lambda count: redirected(planned, moving[:count], step))

    def preview(self, times: ArrayLike) -> Array:
        """Return the desired motion at times (K,), s: (K, 19), in the layout of `cdpr.model`.

        It contains the effects of past events, not those of later ones.

        Raises:
            CdprError: if the times are not finite numbers (K,).
        """
        past = bisect_right(self._changes, round(self._now[0] / self._step))
        motion = self._motion if past == len(self._changes) else self._after(past)
        found = checked(np.atleast_1d(times), (None,), "preview: times", finite=True)
        return np.array([motion.sample(time) for time in found.tolist()]).reshape(-1, 19)

    def decide(self, time: float, state: Array, desired: Array, out: Array) -> None:
        """Write the controller's output of this control step: a new one if it is due, else the held one."""
        if round(time / self._step) % self.period == 0 or not self._called[0]:
            self._control(time, state, desired, self._held)
            self._called[0] = 1.0
        out[:] = self._held

    def correct(self, stage: TensionStage) -> None:
        """Let a stage send the tensions of the controller's inner loop, if it has one, in place of those distributed.

        The policy `hold_tension` holds the distributed ones.
        """
        if self._corrects:
            add_inner_loop(self._controller, stage, self._distributed)

    def record(self, stage: TensionStage | CommandStage) -> None:
        """Let a stage store the tensions as sent, before faults act on them, if something reads them."""
        if self._records:
            sent = bind("copy", source=stage.live.tension, target=self._sent)
            stage.operations.append(Operation("distribution", sent))

    def reset(self) -> None:
        """Forget held output, sent and distributed tensions."""
        self._held[:], self._called[:], self._sent[:], self._distributed[:] = np.nan, 0.0, 0.0, 0.0
