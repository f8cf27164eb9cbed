"""Reference integrator for platforms with a guide, with the same scheme in the coordinates of the guide."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.cables.tables import line_table
from cdpr.mechanics.guide import Guide
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr_backends.scheme import Integrator


class GuidedReference(Integrator):
    """Classical Runge-Kutta scheme of fourth order in position and hinge angle.

    The cables are evaluated at every stage.
    """

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.guide = guide = Guide(robot)
        self._motion = np.zeros(8)  # position, angle, velocity, angular rate
        self._inertial = robot.inertial.copy()
        self.bind_steps(
            "guided_step",
            guide=guide.packed,
            lines=line_table(robot),
            inertial=self._inertial,
            gravity=self.gravity,
            command=self.command,
            external=self.external,
            motion=self._motion,
        )
        self.arrays = (self.command, self.external, self._motion, self.state)

    def load(self, robot: Robot) -> None:
        """Move another platform from now on; the coordinates of the guide do not depend on it."""
        self.robot = robot
        self._inertial[:] = robot.inertial

    def reset(self, state: Array) -> None:
        """Set the platform to `state` (13,), which must be possible in the guide."""
        self.state[:] = state
        axis = self.guide.packed[3:]
        self._motion[:] = [*state[:3], self.guide.angle(state), *self.guide.packed[:3] * state[7:10], axis @ state[10:]]
        self._steps(0)()
        self.restart()
