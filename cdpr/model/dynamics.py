"""Statics and inverse dynamics of the platform. Conventions: see `cdpr.model`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cdpr.model import kernels
from cdpr.model.kinematics import STILL
from cdpr.model.robot import Array, Robot


def required_wrench(
    robot: Robot,
    state: Array,
    gravity: Sequence[float] | Array,
    acceleration: Sequence[float] | Array = STILL,
    angular_acceleration: Sequence[float] | Array = STILL,
) -> Array:
    """Wrench (6,) that the cables must exert to accelerate the platform: force, moment about the origin, world axes.

    `state` is (13,), `gravity` and `acceleration` (of the origin) are in m/s^2, `angular_acceleration` in rad/s^2, all
    world axes. At rest and without acceleration this is the statics: -m g, and its moment about the origin.
    """
    wrench = np.empty(6)
    kernels.inverse_dynamics(
        robot.inertial,
        np.array(gravity, dtype=np.float64),
        kernels.quaternion(np.array(state, dtype=np.float64), 3),
        kernels.vector(np.array(state, dtype=np.float64), 10),
        kernels.vector(np.array(acceleration, dtype=np.float64), 0),
        kernels.vector(np.array(angular_acceleration, dtype=np.float64), 0),
        wrench,
    )
    return wrench
