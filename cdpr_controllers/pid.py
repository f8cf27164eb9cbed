"""Proportional, integral and damping control in task space."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.jit import any_width, kernel
from cdpr.model.kernels import conjugate, inverse_dynamics, logarithm, multiply, proportional_derivative, quaternion
from cdpr.model.lanes import choose
from cdpr.model.robot import Array
from cdpr.plugins import Controller, SnapshotOfArrays


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
        self._arguments = (
            self._pd,
            self._per_step,
            robot.inertial,
            np.array(gravity, dtype=np.float64),
            self._integral,
        )
        self.connect(np.zeros(4))

    def change(self, options: Any) -> None:
        """Take other gains and limits; the integral stays, within the new limits from the next step on."""
        self._pd[:6], self._pd[6:] = options.kp, options.kd
        self._ki = options.ki
        self._per_step[0] = np.broadcast_to(options.ki, 6) * self.control_step
        self._per_step[1] = options.integral_limit

    def connect(self, report: Array) -> None:
        """Watch what becomes of the wrench."""
        self._law = partial(law, *self._arguments, report)

    def control(self, time: float, state: Array, desired: Array, out: Array) -> None:
        """Write the wrench (6,)."""
        self._law(state, desired, out)

    def numbers_in_c(self) -> Mapping[str, Array]:
        """Return gains and limits."""
        kp, kd, ki = self._pd[:6], self._pd[6:], np.broadcast_to(self._ki, 6)
        return {"kp": kp, "kd": kd, "ki": ki, "integral_limit": self._per_step[1]}

    def compiled(self, state: Array, desired: Array, out: Array) -> Callable[[], object] | None:
        """Return the law with these arrays."""
        return partial(self._law, state, desired, out)

    def reset(self) -> None:
        """Clear the integral."""
        self._integral[:] = 0.0


@any_width
@kernel
def law(
    pd: Array,
    per_step: Array,
    inertial: Array,
    gravity: Array,
    integral: Array,
    report: Array,
    state: Array,
    desired: Array,
    wrench: Array,
) -> None:
    """Write the wrench (6,) and advance the integral (6,).

    `pd` are kp (6) and kd (6); `per_step` (2, 6) holds ki times the control step and the limits of the integral.
    """
    linear, angular = proportional_derivative(state, desired, pd)
    e = logarithm(multiply(quaternion(desired, 3), conjugate(quaternion(state, 3))))
    delivered = report[0] == 0.0
    for i in range(6):
        error = desired[i] - state[i] if i < 3 else e[i - 3]
        z = integral[i]
        change = per_step[0, i] * error
        within = min(max(z + change, -per_step[1, i]), per_step[1, i])
        integral[i] = choose(delivered | (z * change < 0.0), within, z)
    a = (linear[0] + integral[0], linear[1] + integral[1], linear[2] + integral[2])
    alpha = (angular[0] + integral[3], angular[1] + integral[4], angular[2] + integral[5])
    inverse_dynamics(inertial, gravity, quaternion(state, 3), (0.0, 0.0, 0.0), a, alpha, wrench)
