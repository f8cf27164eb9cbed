"""Simplification of polylines."""

from __future__ import annotations

import numpy as np

from cdpr.model.robot import Array


def thinned(points: Array, tolerance: float) -> Array:
    """Return a subset of points (k, 3), m, whose polyline stays within `tolerance` (m) of all points.

    Both ends are kept. Algorithm: Ramer (1972), Douglas and Peucker (1973).
    """
    kept = np.zeros(len(points), dtype=bool)
    kept[[0, -1]] = True
    pieces = [(0, len(points) - 1)]
    while pieces:
        first, last = pieces.pop()
        distance = _distances(points[first : last + 1])
        k = int(np.argmax(distance))
        if distance[k] > tolerance:
            kept[first + k] = True
            pieces += [(first, first + k), (first + k, last)]
    return points[kept]


def _distances(points: Array) -> Array:
    """Return the distance (m) of each point from the segment between the first and the last."""
    along = points[-1] - points[0]
    length = float(np.linalg.norm(along))
    away = points - points[0]
    if length > 0.0:
        share = np.clip(np.sum(away * along, axis=1) / length**2, 0.0, 1.0)
        away = away - share[:, None] * along
    distances: Array = np.linalg.norm(away, axis=1)
    return distances
