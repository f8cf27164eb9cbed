"""Calls of a controller at its own period, and its further inputs."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.base.errors import PluginError
from cdpr.model.robot import Array, read_only
from cdpr.native.bind import bind
from cdpr.plugins import Controller, ControllerInputs, SnapshotOfArrays
from cdpr.simulation.parts import Parts
from cdpr.tension.command import CommandStage
from cdpr.tension.current_sample import Cables
from cdpr.tension.operations import Operation
from cdpr.trajectory import Trajectory

if TYPE_CHECKING:
    from cdpr.tension.stage import TensionStage


def observes(controller: Controller) -> bool:
    """Return True if a controller uses `ControllerInputs`."""
    return isinstance(controller, Controller) and type(controller).observe is not Controller.observe


def period_of(controller: Controller) -> int:
    """Return the number of control steps between two calls of a controller.

    Raises:
        PluginError: if it is not a whole number, at least 1.
    """
    period: Any = getattr(controller, "period", 1)
    if isinstance(period, bool) or not isinstance(period, int | np.integer) or period < 1:
        name = type(controller).__name__
        raise PluginError(f"{name}.period: expected a whole number of control steps, at least 1, got {period!r}")
    return int(period)


class ControllerCalls(SnapshotOfArrays):
    """Controller that is called every `period` control steps, with its output held in between.

    Args:
        parts: parts of the loop.
        cables: limits of the cables.
        locked: (m,), True for cables that the distribution has locked, live.

    Attributes:
        period: number of control steps.
        motion: desired motion of the preview; may be replaced.
        arrays: state; () for controllers that are called in each control step, without further inputs.
    """

    def __init__(self, parts: Parts, cables: Cables, locked: NDArray[np.bool_]) -> None:
        controller = parts.controller
        self._control, self._step = controller.control, parts.control_step
        self.period = period_of(controller)
        self.motion: Trajectory = parts.trajectory
        self._held = np.zeros(6 if parts.output == "wrench" else parts.robot.m)
        self._called = np.zeros(1)  # 0 before the first call
        self._sent = np.zeros(parts.robot.m)
        self._observes = observes(controller)
        self.arrays = (self._held, self._called, self._sent) if self._observes or self.period > 1 else ()
        if self._observes:
            known = locked.view()
            known.flags.writeable = False
            limits, sent = read_only(cables.limits), read_only(self._sent)
            controller.observe(ControllerInputs(self.preview, limits, known, sent, MappingProxyType({})))

    def preview(self, times: ArrayLike) -> Array:
        """Return the desired motion at times (K,), s: (K, 19), in the layout of `cdpr.model`."""
        samples = [self.motion.sample(float(time)) for time in np.atleast_1d(np.asarray(times, dtype=np.float64))]
        return np.array(samples).reshape(-1, 19)

    def decide(self, time: float, state: Array, desired: Array, out: Array) -> None:
        """Write the controller's output of this control step: a new one if it is due, else the held one."""
        if round(time / self._step) % self.period == 0 or not self._called[0]:
            self._control(time, state, desired, self._held)
            self._called[0] = 1.0
        out[:] = self._held

    def record(self, stage: TensionStage | CommandStage) -> None:
        """Let a stage store the tensions as sent, before faults act on them, if the controller observes them."""
        if self._observes:
            sent = bind("copy", source=stage.live.tension, target=self._sent)
            stage.operations.append(Operation("distribution", sent))

    def reset(self) -> None:
        """Forget held output and sent tensions."""
        self._held[:], self._called[:], self._sent[:] = 0.0, 0.0, 0.0
