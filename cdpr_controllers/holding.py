"""Arguments of the tensions that hold the platform still (holding.hpp)."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.cables.tables import line_table
from cdpr.model import Robot
from cdpr.model.robot import Array


def holding_arguments(robot: Robot, gravity: Array, pretension: float) -> dict[str, Any]:
    """Return the constant arguments, by name.

    Args:
        robot: robot with the limits of its cables.
        gravity: (3,), m/s^2, world.
        pretension: tension of each cable to stay near, N.
    """
    rows = np.array(robot.rows)
    return {
        "lines": line_table(robot),
        "rows": rows,
        "weights": np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[rows],
        "low": robot.tension_min - pretension,
        "high": robot.tension_max - pretension,
        "pretension": pretension,
        "inertial": robot.inertial.copy(),
        "gravity": np.array(gravity, dtype=np.float64),
    }
