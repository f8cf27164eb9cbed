"""Proportional, integral and damping control in task space."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins.controller import Tunable
from cdpr_controllers.law import GainLaw


class Pid(GainLaw):
    """PID law with gravity compensation at the current pose.

    wrench = M (kp e + z + kd e') - G with e = x_d - x and z the integral of ki e over time, for each degree of freedom
    in world axes. For the attitude, e is a rotation vector. The integral cancels any constant load. The error follows
    e''' + kd e'' + kp e' + ki e = 0 for a constant target, which is stable if ki < kp kd. The integral is a sum over
    the control steps including the current one.

    Anti-windup limits z to +-integral_limit. If the cables did not exert the requested wrench in the previous step (the
    status of the tension stage is not OK), z only moves towards zero.
    """

    operation = "pid"

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        self._per_step, self._integral = np.zeros((2, 6)), np.zeros(6)
        more = {"per_step": self._per_step, "integral": self._integral, "report": np.zeros(4)}
        super().__init__(robot, gravity, control_step, options, **more)
        self.arrays = (self._integral,)

    def change(self, options: Any) -> None:
        """Set new gains and limits. The integral keeps its value, within the new limits from the next step on."""
        super().change(options)
        self._ki = options.ki
        self._per_step[0] = np.broadcast_to(options.ki, 6) * self.control_step
        self._per_step[1] = options.integral_limit

    def renew(self, robot: Robot) -> bool:
        """Use the mass properties of another platform; the integral does not depend on them."""
        return super().renew(robot)

    def connect(self, report: Array) -> None:
        """Read the result of the wrench from the report of the tension stage."""
        self._give(report=report)

    def tunable(self) -> Mapping[str, Tunable]:
        """Return the gains and limits."""
        per_step, limit = self._per_step
        return {
            **super().tunable(),
            "ki": Tunable(per_step, np.broadcast_to(self._ki, 6).astype(float), per_step=True),
            "integral_limit": Tunable(limit, limit.copy()),
        }

    def reset(self) -> None:
        """Reset the integral."""
        self._integral[:] = 0.0
