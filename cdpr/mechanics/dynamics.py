"""Statics and inverse dynamics of the platform. Conventions: see `cdpr.model`."""

from __future__ import annotations

from collections.abc import Sequence

from cdpr.mechanics.kinematics import STILL
from cdpr.model.arrays import checked
from cdpr.model.robot import Array, Robot
from cdpr.native.compute import compute


def required_wrench(
    robot: Robot,
    state: Array,
    gravity: Sequence[float] | Array,
    acceleration: Sequence[float] | Array = STILL,
    angular_acceleration: Sequence[float] | Array = STILL,
) -> Array:
    """Wrench (6,) that the cables must exert to accelerate the platform: force, moment about the origin, world axes.

    `state` is (13,), `gravity` and `acceleration` (of the origin) are in m/s^2, `angular_acceleration` in rad/s^2, all
    world axes. At rest and without acceleration this is the statics: -m g, and its moment about the origin. Raises
    CdprError where an array has another shape or holds no real numbers.
    """
    given = {
        "state": checked(state, (13,), "state"),
        "gravity": checked(gravity, (3,), "gravity"),
        "acceleration": checked(acceleration, (3,), "acceleration"),
        "angular_acceleration": checked(angular_acceleration, (3,), "angular acceleration"),
    }
    _, (wrench,) = compute("inverse_dynamics", {"inertial": robot.inertial, **given}, {"wrench": (6,)})
    return wrench
