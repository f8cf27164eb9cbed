"""Distances of segments from each other, and from convex solids: compiled operations on numpy arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.bind import bind


def segment_distances(first: ArrayLike, second: ArrayLike) -> Array:
    """Compute the distances between pairs of segments.

    Args:
        first: (k, 6) m, both ends of each.
        second: (k, 6) m.

    Returns:
        (k,) m.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> segment_distances([[0, 0, 0, 1, 0, 0]], [[0, 2, 0, 1, 2, 0]])
        array([2.])
    """
    one, other = _array(first), _array(second)
    distance = np.empty(len(one))
    bind("segment_distances", first=one, second=other, distance=distance)()
    return distance


def solid_distances(solid: ArrayLike, segments: ArrayLike) -> Array:
    """Compute the distances of segments from a convex solid.

    Args:
        solid: (11 or more,), as of `cdpr.mechanics.solids.row`.
        segments: (k, 6) m, both ends of each, world frame; of a point both are the same.

    Returns:
        (k,) m; negative where a segment passes through the solid: its depth below the surface at the deepest point.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> solid_distances(row(Sphere(0.5)), [[2, 0, -1, 2, 0, 1]])
        array([1.5])
    """
    row, ends = _array(solid), _array(segments)
    distance = np.empty(len(ends))
    bind("solid_distances", solid=row, segments=ends, distance=distance)()
    return distance


def _array(given: ArrayLike) -> Array:
    return np.ascontiguousarray(given, dtype=np.float64)
