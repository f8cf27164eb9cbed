"""Reference integrator for cables on winches, which integrates the winches with the platform at every stage."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.mechanics.body_frame import BodyFrame
from cdpr.mechanics.winches import Winches
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import Backend
from cdpr.plugins.backend import Acts
from cdpr.plugins.snapshots import SnapshotOfArrays
from cdpr_backends.scheme import steps_of


class WinchReference(SnapshotOfArrays, Backend):
    """Classical Runge-Kutta scheme of fourth order in body, winches and cable work, for free and guided platforms."""

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.frame = frame = BodyFrame(robot)
        self._body, applied = np.zeros(13), np.zeros(6)
        self.winches = winches = Winches(
            robot, frame, self.gravity, self.command, self.external, self._body, applied, physics_step
        )
        self.highest = winches.highest
        self._to_body = bind("body_state", offset=frame.offset, state=self.state, body=self._body)
        self._publish = bind("platform_state", offset=frame.offset, body=self._body, state=self.state)
        self._steps = steps_of("winch_runge_kutta", **winches.given, state=self.state, step=self.physics_step)
        self.arrays = (self.command, self.external, self._body, self.state, *self.winches.arrays)

    def reset(self, state: Array) -> None:
        """Set the platform to `state` (13,), which must be possible in the guide, if there is one."""
        self.state[:] = state
        self.state[7:] *= self.winches.free
        self._to_body()
        self._publish()
        self.winches.reset()

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        self._steps(n)()

    def acts(self, n: int) -> Acts:
        """Return the integrator for n physics steps."""
        return [self._steps(n)]

    def read_tension(self, tension: Array) -> None:
        """Write the tensions (m,)."""
        self.winches.settle()
        tension[:] = self.winches.tension

    def readings(self, tension: Array, work: Array) -> tuple[Acts, Acts] | None:
        """Return the operations that write tensions and work; the work is integrated with the other states."""
        tensions, _ = self.winches.readings(tension, work)
        return tensions, [bind("copy", source=self.winches.work, target=work)]

    def cable_work(self) -> float:
        """Return the work of the cables on the platform [J]."""
        return float(self.winches.work[0])
