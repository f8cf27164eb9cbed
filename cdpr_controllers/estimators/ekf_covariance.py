"""Covariance of an extended Kalman filter: densities of the unknown wrench."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array

# Default densities of the unknown wrench, as shares of the weight (sqrt(s)): of models that are good, and without known
# tensions, when it is all of the wrench that accelerates the platform.
KNOWN, UNKNOWN = 1e-3, 0.1
STANDARD_GRAVITY = 9.80665  # m/s^2


def densities(robot: Robot, options: Any) -> Array:
    """Return the densities of the unknown wrench.

    Args:
        robot: nominal robot.
        options: options of the filter.

    Returns:
        (2, 2), of force, N^2 s, and moment, (N m)^2 s: with known tensions, and without.
    """
    weight = robot.platform.mass * STANDARD_GRAVITY
    force = [KNOWN * weight if options.force_noise is None else options.force_noise, UNKNOWN * weight]
    moment = [each * robot.characteristic_length for each in force]
    if options.moment_noise is not None:
        moment[0] = options.moment_noise
    return np.square([[force[0], moment[0]], [force[1], moment[1]]])
