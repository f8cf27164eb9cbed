"""Platforms that a guide keeps from moving in some directions: point masses, planar robots, carriages.

The guide lets the origin move along some of the world's axes and the platform turn about at most one of them, through
the origin; or it holds the origin and lets the platform turn about all three, on a ball (`cdpr.mechanics.spherical`).
Its coordinates are the origin's position and the angle; in the held directions it takes whatever force or moment comes.
A centre of mass off the origin loads the guide, and couples turning with moving.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array, Robot

IntArray = NDArray[np.int64]


class Guide:
    """What a robot with fewer than six degrees of freedom is held by.

    Attributes:
        rows: (n,) rows of a wrench (6,) that the coordinates belong to.
        slides: which world axes the origin moves along, 0, 1, 2 for x, y, z, in this order.
        hinge: which world axis the platform turns about, None where it turns about none or about all.
        spherical: whether it turns about all, the origin being held; the functions of this file are not for that.
    """

    def __init__(self, robot: Robot) -> None:
        rows = robot.rows
        self.rows: IntArray = np.array(rows)
        self.slides = tuple(row for row in rows if row < 3)
        turns = [row - 3 for row in rows if row >= 3]
        self.hinge = turns[0] if len(turns) == 1 else None
        self.spherical = len(turns) == 3

    @cached_property
    def packed(self) -> Array:
        """For the kernels, (6,): 1 along and about each free axis, so that the last three are the hinge, if any."""
        packed = np.zeros(6)
        packed[self.rows] = 1.0
        return packed

    def coordinates(self, state: Array, home: Array) -> tuple[Array, Array]:
        """Joint coordinates and rates (n,) of a state (13,), slides measured from `home` (3,)."""
        motion = np.concatenate([state[:3] - home, [self.angle(state)] * 3])
        return motion[self.rows], state[7:13][self.rows]

    def angle(self, state: Array) -> float:
        """Angle about the hinge, rad, of a state (13,)."""
        return 0.0 if self.hinge is None else 2.0 * math.atan2(state[4 + self.hinge], state[3])
