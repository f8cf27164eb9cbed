"""Curves of cables that sag."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.arrays import real
from cdpr.native.bind import bind


def cable_curves(
    lines: Array, chains: Array, gravity: ArrayLike, poses: ArrayLike, unwound: ArrayLike, count: int
) -> Array:
    """Return points of cables from the frame to the platform.

    Args:
        lines: (m, w), as in `cdpr.cables.tables.line_table`.
        chains: (m, 33), as in `cdpr.cables.tables.chain_table` or `span_table`.
        gravity: (3,) m/s^2, world axes.
        poses: (n, 7) positions [m] and quaternions w, x, y, z.
        unwound: (n, m) unwound lengths [m].
        count: points of a cable, at least 2.

    Returns:
        (n, m, count, 3) m, world frame, at equal unstretched lengths. Cables that do not sag, or that have no
            equilibrium with their length, are straight.

    Raises:
        ValueError: if the shapes do not match.
    """
    lengths = real(unwound, "unwound")
    points = np.empty((*lengths.shape, count, 3))
    table, down = real(poses, "poses"), real(gravity, "gravity")
    bind("cable_curves", lines=lines, chains=chains, gravity=down, poses=table, unwound=lengths, points=points)()
    return points
