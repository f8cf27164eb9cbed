"""Reference integrator for cables on winches, which integrates the winches with the platform at every stage."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.mechanics.anchors import Anchors
from cdpr.mechanics.body_frame import BodyFrame
from cdpr.mechanics.winches import Winches
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins.backend import Operations
from cdpr_backends.scheme import Integrator


class WinchReference(Integrator):
    """Classical Runge-Kutta scheme of fourth order in body, winches and cable work, for free and guided platforms."""

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.frame = frame = BodyFrame(robot)
        self._body, applied = np.zeros(13), np.zeros(6)
        self.winches = winches = Winches(
            robot, frame, self.gravity, self.command, self.external, self._body, applied, physics_step
        )
        self.highest, self.brakes = winches.highest, winches.brakes
        self._to_body = bind("body_state", offset=frame.offset, state=self.state, body=self._body)
        self._publish = bind("platform_state", offset=frame.offset, body=self._body, state=self.state)
        self.bind_steps("winch_runge_kutta", **winches.given)
        self.arrays = (self.command, self.external, self._body, self.state, *self.winches.arrays)

    def load(self, robot: Robot) -> None:
        """Move another platform from now on, with the same pose and twist of its origin."""
        self.winches.settle_before_change()
        self.robot = robot
        self.frame.refill(robot)
        self._to_body()
        self.winches.change_body(robot, self.frame)

    def reset(self, state: Array) -> None:
        """Set the platform to `state` (13,), which must be possible in the guide, if there is one."""
        self.state[:] = state
        self.state[7:] *= self.winches.free
        self._to_body()
        self._publish()
        self.winches.reset()
        self.restart()

    def follow(self, anchors: Anchors) -> None:
        """Evaluate the cables with anchors that move, at the time of each stage."""
        super().follow(anchors)
        assert self._anchors is not None
        self.winches.follow(self._anchors)

    def read_tension(self, tension: Array) -> None:
        """Write the tensions (m,)."""
        self.winches.settle()
        tension[:] = self.winches.tension

    def readings(self, tension: Array, work: Array) -> tuple[Operations, Operations] | None:
        """Return the operations that write tensions and work; the work is integrated with the other states."""
        tensions, _ = self.winches.readings(tension, work)
        return tensions, [bind("copy", source=self.winches.work, target=work)]

    def winch_readings(self, unwound: Array, unwinding: Array, torque: Array) -> Operations:
        """Return the operation that writes the state of the winches."""
        return self.winches.reading(unwound, unwinding, torque)

    def winch_tensions(self, tension: Array) -> Operations:
        """Return the operation that writes the tensions at the winches."""
        return self.winches.winch_tensions(tension)

    def drum_readings(self, angle: Array, speed: Array, torque: Array, power: Array) -> Operations:
        """Return the operation that writes the motion of the drums."""
        return self.winches.drum_readings(angle, speed, torque, power)

    def bent_readings(self, unstretched: Array, bending: Array) -> Operations | None:
        """Return the operations that read cables which sag."""
        return self.winches.bent_readings(unstretched, bending)

    def cable_work(self) -> float:
        """Return the work of the cables on the platform [J]."""
        return float(self.winches.work[0])
