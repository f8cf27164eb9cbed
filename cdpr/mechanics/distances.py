"""Distances between segments and of segments from convex solids, computed by compiled operations on numpy arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.arrays import real
from cdpr.native.bind import bind


def segment_distances(first: ArrayLike, second: ArrayLike) -> Array:
    """Compute the distances between pairs of segments.

    Args:
        first: (k, 6) both ends of each first segment [m].
        second: (k, 6) both ends of each second segment [m].

    Returns:
        (k,) distances [m].

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> segment_distances([[0, 0, 0, 1, 0, 0]], [[0, 2, 0, 1, 2, 0]])
        array([2.])
    """
    one, other = real(first, "first"), real(second, "second")
    distance = np.empty(len(one))
    bind("segment_distances", first=one, second=other, distance=distance)()
    return distance


def solid_distances(solid: ArrayLike, segments: ArrayLike) -> Array:
    """Compute the distances of segments from a convex solid.

    Args:
        solid: (11 or more,) row of `cdpr.mechanics.solids.row`.
        segments: (k, 6) both ends of each segment in the world frame [m]; equal ends for a point.

    Returns:
        (k,) distances [m]. The value is negative if the segment passes through the solid: it is then the depth of its
        deepest point below the surface.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> from cdpr.mechanics.solids import row
        >>> from cdpr.model import Sphere
        >>> solid_distances(row(Sphere(0.5)), [[2, 0, -1, 2, 0, 1]])
        array([1.5])
    """
    row, ends = real(solid, "solid"), real(segments, "segments")
    distance = np.empty(len(ends))
    bind("solid_distances", solid=row, segments=ends, distance=distance)()
    return distance
