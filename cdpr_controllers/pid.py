"""Proportional, integral and damping control in task space."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import Controller, SnapshotOfArrays
from cdpr.plugins.controller import Tunable
from cdpr_controllers.law import Law


class Pid(SnapshotOfArrays, Controller):
    """PID law with gravity compensation at the current pose.

    wrench = M (kp e + z + kd e') - G with e = x_d - x and z the integral of ki e over time, for each degree of freedom
    in world axes. For the attitude, e is a rotation vector. The integral cancels any constant load. The error follows
    e''' + kd e'' + kp e' + ki e = 0 for a constant target, which is stable if ki < kp kd. The integral is a sum over
    the control steps including the current one.

    Anti-windup limits z to +-integral_limit. If the cables did not exert the requested wrench in the previous step (the
    status of the tension stage is not OK), z only moves towards zero.
    """

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        super().__init__(robot, gravity, control_step, options)
        self._pd, self._per_step, self._integral = np.zeros(12), np.zeros((2, 6)), np.zeros(6)
        self.change(options)
        self.arrays = (self._integral,)
        self._body = {"inertial": robot.inertial.copy(), "gravity": np.array(gravity, dtype=np.float64)}
        self.connect(np.zeros(4))

    def change(self, options: Any) -> None:
        """Set new gains and limits. The integral keeps its value, within the new limits from the next step on."""
        self._pd[:6], self._pd[6:] = options.kp, options.kd
        self._ki = options.ki
        self._per_step[0] = np.broadcast_to(options.ki, 6) * self.control_step
        self._per_step[1] = options.integral_limit

    def connect(self, report: Array) -> None:
        """Read the result of the wrench from the report of the tension stage."""
        self._report = report
        self._law = Law(self._bound, 6)

    def renew(self, robot: Robot) -> bool:
        """Use the mass properties of another platform."""
        self.robot = robot
        self._body["inertial"][:] = robot.inertial
        return True

    def control(self, time: float, state: Array, desired: Array, out: Array) -> None:
        """Write the wrench (6,)."""
        self._law(state, desired, out)

    def tunable(self) -> Mapping[str, Tunable]:
        """Return the gains and limits."""
        kp, kd, (per_step, limit) = self._pd[:6], self._pd[6:], self._per_step
        return {
            "kp": Tunable(kp, kp.copy()),
            "kd": Tunable(kd, kd.copy()),
            "ki": Tunable(per_step, np.broadcast_to(self._ki, 6).astype(float), per_step=True),
            "integral_limit": Tunable(limit, limit.copy()),
        }

    def compiled(self, state: Array, desired: Array, out: Array) -> Callable[[], object]:
        """Return the law bound to these arrays."""
        return self._bound(state, desired, out)

    def reset(self) -> None:
        """Reset the integral."""
        self._integral[:] = 0.0

    def _bound(self, state: Array, desired: Array, out: Array) -> Callable[[], object]:
        return bind(
            "pid",
            gains=self._pd,
            per_step=self._per_step,
            **self._body,
            report=self._report,
            state=state,
            desired=desired,
            integral=self._integral,
            wrench=out,
        )
