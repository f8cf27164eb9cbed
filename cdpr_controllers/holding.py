"""Tensions that hold the platform up at a pose: the feed-forward of controllers that put out commands."""

from __future__ import annotations

import numpy as np

from cdpr.cables.tables import line_table
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind


class Holding:
    """Balances the weight within the limits, as close to `pretension` (N) in each cable as that allows.

    With pretension 0 it is the distribution of least norm. Where no tensions within the limits balance the weight it
    is the nearest that can be done (`box_least_squares`, which differs from the exact answer by 1e-5 of the load).

    Attributes:
        tension: (m,) N, live.
    """

    def __init__(self, robot: Robot, gravity: Array, pretension: float) -> None:
        rows = np.array(robot.rows)
        self.tension = np.full(robot.m, pretension)
        self._pose = np.zeros(7)
        self._balance = bind(
            "holding",
            lines=line_table(robot),
            rows=rows,
            weights=np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[rows],
            low=robot.tension_min - pretension,
            high=robot.tension_max - pretension,
            pretension=pretension,
            inertial=robot.inertial,
            gravity=np.array(gravity, dtype=np.float64),
            pose=self._pose,
            tension=self.tension,
        )

    def update(self, pose: Array) -> None:
        """Write the tensions for a pose (7,)."""
        self._pose[:] = pose
        self._balance()
