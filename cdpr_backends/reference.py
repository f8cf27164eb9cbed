"""Reference integrator for free platforms: classical Runge-Kutta scheme that evaluates the cables at every stage."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.mechanics.body_frame import BodyFrame
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr_backends.scheme import Integrator, keep_state


class ReferenceBackend(Integrator):
    """Integrator of position, attitude, momentum and angular momentum by the classical scheme of fourth order.

    The variables are those of the centre of mass. The angular momentum is in world axes, where it is constant without a
    torque, so that it is conserved to round-off.
    """

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.frame = frame = BodyFrame(robot)
        self._body = np.zeros(13)
        self._inertial = np.array([frame.mass, *frame.moments])
        self._momentum = np.zeros(3)  # angular, about the centre of mass, in world axes
        moving = {"body": self._body, "momentum": self._momentum}
        self._begin = bind("reference_begin", offset=frame.offset, moments=frame.moments, state=self.state, **moving)
        self.bind_steps(
            "reference_step",
            lines=frame.line_table,
            offset=frame.offset,
            inertial=self._inertial,
            gravity=self.gravity,
            command=self.command,
            external=self.external,
            **moving,
        )
        self.arrays = (self.command, self.external, self._body, self._momentum, self.state)

    def renew(self, robot: Robot) -> bool:
        """Move another platform from the next reset on."""
        before, self.robot = self.robot, robot
        self.frame.mass = self._inertial[0] = robot.platform.mass
        if robot.inertial[1:].tobytes() != before.inertial[1:].tobytes():
            frame = BodyFrame(robot)
            self._inertial[1:] = frame.moments
            for name in ("line_table", "offset", "moments"):
                getattr(self.frame, name)[:] = getattr(frame, name)
        return True

    def load(self, robot: Robot) -> None:
        """Move another platform from now on, with the same pose and twist of its origin."""
        self.renew(robot)
        keep_state(self.state, self._begin)

    def reset(self, state: Array) -> None:
        """Set the platform to `state` (13,)."""
        self.state[:] = state
        self._begin()
        self.restart()
