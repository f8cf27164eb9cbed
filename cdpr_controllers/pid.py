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
    """Holds the platform up at its present pose and pulls it to the desired one, whatever constant load there is.

    wrench = M (kp e + z + kd e') - G with e = x_d - x and z the integral of ki e over time, per degree of freedom in
    world axes; e is a rotation vector for the attitude. The error then obeys e''' + kd e'' + kp e' + ki e = 0 about a
    resting target: stable where ki < kp kd. The integral is a sum over control steps, the present one included.

    Against wind-up, z stays within +-integral_limit; and where the cables did not do what was asked of them in the
    previous step (the tension stage's status is not OK), z only moves towards zero.
    """

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        super().__init__(robot, gravity, control_step, options)
        self._pd, self._per_step, self._integral = np.zeros(12), np.zeros((2, 6)), np.zeros(6)
        self.change(options)
        self.arrays = (self._integral,)
        self._body = {"inertial": robot.inertial, "gravity": np.array(gravity, dtype=np.float64)}
        self.connect(np.zeros(4))

    def change(self, options: Any) -> None:
        """Take other gains and limits; the integral stays, within the new limits from the next step on."""
        self._pd[:6], self._pd[6:] = options.kp, options.kd
        self._ki = options.ki
        self._per_step[0] = np.broadcast_to(options.ki, 6) * self.control_step
        self._per_step[1] = options.integral_limit

    def connect(self, report: Array) -> None:
        """Watch what becomes of the wrench."""
        self._report = report
        self._law = Law(self._bound, 6)

    def control(self, time: float, state: Array, desired: Array, out: Array) -> None:
        """Write the wrench (6,)."""
        self._law(state, desired, out)

    def tunable(self) -> Mapping[str, Tunable]:
        """Return gains and limits."""
        kp, kd, (per_step, limit) = self._pd[:6], self._pd[6:], self._per_step
        return {
            "kp": Tunable(kp, kp.copy()),
            "kd": Tunable(kd, kd.copy()),
            "ki": Tunable(per_step, np.broadcast_to(self._ki, 6).astype(float), per_step=True),
            "integral_limit": Tunable(limit, limit.copy()),
        }

    def compiled(self, state: Array, desired: Array, out: Array) -> Callable[[], object]:
        """Return the law with these arrays."""
        return self._bound(state, desired, out)

    def reset(self) -> None:
        """Clear the integral."""
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
