"""Lines with no more corners than can be seen."""

from __future__ import annotations

import numpy as np

from cdpr.model.robot import Array


def thinned(points: Array, tolerance: float) -> Array:
    """Return those of points (k, 3), m, between which a line stays within `tolerance` (m) of all; the ends always.

    Ramer (1972), Douglas and Peucker (1973).
    """
    if len(points) < 3:
        return points
    along = points[-1] - points[0]
    length = float(np.linalg.norm(along))
    away = points - points[0]
    if length > 0.0:
        share = np.clip(np.sum(away * along, axis=1) / length**2, 0.0, 1.0)
        away = away - share[:, None] * along
    distance = np.linalg.norm(away, axis=1)
    k = int(np.argmax(distance))
    if distance[k] <= tolerance:
        return points[[0, -1]]
    return np.concatenate([thinned(points[: k + 1], tolerance)[:-1], thinned(points[k:], tolerance)])
