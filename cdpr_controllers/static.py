"""Static control: gravity compensation with proportional and damping terms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.jit import any_width, kernel
from cdpr.model.kernels import inverse_dynamics, proportional_derivative, quaternion
from cdpr.model.robot import Array
from cdpr.plugins import Controller, SnapshotOfArrays


class Static(SnapshotOfArrays, Controller):
    """Holds the platform up at its present pose and pulls it towards the desired one.

    wrench = M (kd (v_d - v) + kp (x_d - x)) - G: no desired acceleration and no velocity-dependent terms, so a moving
    target is followed with a lag. With both gains zero it is the bare statics. (The thesis's code uses gains of 50.)
    """

    arrays = ()  # it has no memory

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        super().__init__(robot, gravity, control_step, options)
        self._gains = np.zeros(12)
        self.change(options)
        self._law = partial(law, self._gains, robot.inertial, np.array(gravity, dtype=np.float64))

    def change(self, options: Any) -> None:
        """Take other gains."""
        self._gains[:6], self._gains[6:] = options.kp, options.kd

    def control(self, time: float, state: Array, desired: Array, wrench: Array) -> None:
        """Write the wrench (6,)."""
        self._law(state, desired, wrench)

    def numbers_in_c(self) -> Mapping[str, Array]:
        """Return the gains."""
        return {"kp": self._gains[:6], "kd": self._gains[6:]}

    def compiled(self, state: Array, desired: Array, out: Array) -> Callable[[], object] | None:
        """Return the law with these arrays."""
        return partial(self._law, state, desired, out)


@any_width
@kernel
def law(gains: Array, inertial: Array, gravity: Array, state: Array, desired: Array, wrench: Array) -> None:
    """Write the wrench (6,) of static control; gains are kp (6) and kd (6)."""
    linear, angular = proportional_derivative(state, desired, gains)
    inverse_dynamics(inertial, gravity, quaternion(state, 3), (0.0, 0.0, 0.0), linear, angular, wrench)
