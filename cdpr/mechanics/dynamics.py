"""Statics and inverse dynamics of the platform. See `cdpr.model` for the conventions."""

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
    """Return the wrench (6,) that the cables must exert to accelerate the platform.

    At rest and without acceleration, the wrench balances the weight: -m g and its moment about the origin.

    Args:
        robot: robot with the mass and the inertia of the platform.
        state: (13,) state of the platform.
        gravity: (3,) gravity [m/s^2], in world axes.
        acceleration: (3,) acceleration of the origin [m/s^2], in world axes.
        angular_acceleration: (3,) angular acceleration [rad/s^2], in world axes.

    Returns:
        (6,) force [N] and moment about the platform's origin [N m], in world axes.

    Raises:
        CdprError: if an array has another shape or does not contain real numbers.
    """
    given = {
        "state": checked(state, (13,), "state"),
        "gravity": checked(gravity, (3,), "gravity"),
        "acceleration": checked(acceleration, (3,), "acceleration"),
        "angular_acceleration": checked(angular_acceleration, (3,), "angular acceleration"),
    }
    _, (wrench,) = compute("inverse_dynamics", {"inertial": robot.inertial, **given}, {"wrench": (6,)})
    return wrench
