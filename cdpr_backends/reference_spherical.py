"""Reference integrator for platforms that rotate about their fixed origin, with the scheme of the free platform."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.cables.tables import line_table
from cdpr.mechanics.spherical import pack
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr_backends.scheme import Integrator, keep_state


class SphericalReference(Integrator):
    """Classical Runge-Kutta scheme of fourth order in attitude and angular momentum about the origin.

    The angular momentum is in world axes, so that it is conserved to round-off without a torque.
    """

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self._momentum = np.zeros(3)
        self._packed = packed = pack(robot)
        moving = {"momentum": self._momentum}
        self._begin = bind("spherical_begin", packed=packed, state=self.state, **moving)
        self.bind_steps(
            "spherical_step",
            lines=line_table(robot),
            packed=packed,
            gravity=self.gravity,
            command=self.command,
            external=self.external,
            **moving,
        )
        self.arrays = (self.command, self.external, self._momentum, self.state)

    def load(self, robot: Robot) -> None:
        """Move another platform from now on, with the same attitude and angular velocity."""
        self.robot = robot
        self._packed[:] = pack(robot)
        keep_state(self.state, self._begin)

    def reset(self, state: Array) -> None:
        """Set the platform to `state` (13,), whose velocity must be zero."""
        self.state[:] = state
        self.state[7:10] = 0.0
        self._begin()
        self.restart()
