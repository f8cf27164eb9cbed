"""Guides that restrict the motion of a platform: point masses, planar robots, carriages.

The guide lets the origin translate along some world axes. It lets the platform rotate about at most one world axis
through the origin, or about all three on a spherical joint with a fixed origin (`cdpr.mechanics.spherical`). The
coordinates of the guide are the position of the origin and the angle. The guide takes any force and moment in the
directions that it blocks. A centre of mass off the origin loads the guide and couples rotation with translation.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array, Robot

IntArray = NDArray[np.int64]


class Guide:
    """Guide of a robot with fewer than six degrees of freedom.

    Attributes:
        rows: (n,) rows of a wrench (6,) that belong to the coordinates.
        slides: world axes along which the origin translates, 0, 1, 2 for x, y, z, in this order.
        hinge: world axis about which the platform rotates, None if it rotates about none or all of them.
        spherical: True if the platform rotates about all axes and the origin is fixed. The other functions of this file
            do not apply to such a guide.
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
        """(6,) 1 along and about each free axis, for the kernels. The last three entries describe the hinge, if any."""
        packed = np.zeros(6)
        packed[self.rows] = 1.0
        return packed

    def coordinates(self, state: Array, home: Array) -> tuple[Array, Array]:
        """Return the joint coordinates and rates (n,) of a state (13,), with translations relative to `home` (3,)."""
        motion = np.concatenate([state[:3] - home, [self.angle(state)] * 3])
        return motion[self.rows], state[7:13][self.rows]

    def angle(self, state: Array) -> float:
        """Return the angle about the hinge of a state (13,) [rad]."""
        return 0.0 if self.hinge is None else 2.0 * math.atan2(state[4 + self.hinge], state[3])
