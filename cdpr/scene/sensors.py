"""Drawings of sensors: frustums of cameras, rays to measured distances, and points of other sensors."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cdpr.model import rotations
from cdpr.model.robot import Array, frozen_array

NONE = frozen_array(np.empty((0, 3)))
IDENTITY = frozen_array(np.array([1.0, 0.0, 0.0, 0.0]))


@dataclass(frozen=True, eq=False)
class SensorDrawing:
    """Drawing of a sensor: what is fixed, in the axes of the body that carries it, and the column that it reads."""

    name: str
    carried: bool  # True if the platform carries it, else the world
    at: Array  # (3,), m
    attitude: Array = field(default_factory=lambda: IDENTITY)  # (4,), of the sensor's axes
    edges: Array = field(default_factory=lambda: NONE)  # (2 k, 3), m: pairs of ends, such as the edges of a frustum
    marks: Array = field(default_factory=lambda: NONE)  # (k, 3), m: points of the other body that it sees
    rays: Array = field(default_factory=lambda: NONE)  # (k, 3), unit vectors from `at`
    column: str = ""  # distances along the rays, or 1 for each mark that it sees
    chosen: tuple[int, ...] = ()  # the values of this column that are drawn

    def read(self, rows: Array) -> Array:
        """Return the values to draw (n, k) of the rows (n, w) of its column."""
        return np.asarray(rows.reshape(len(rows), -1)[:, self.chosen])

    def tips(self, position: Array, orientation: Array, distances: Array) -> Array:
        """Return the ends (n, k, 3), m, world axes, of its rays at poses (n, 3) and (n, 4) with distances (n, k)."""
        local = self.at + distances[..., None] * self.rays
        return np.asarray(position[:, None] + np.einsum("nij,nkj->nki", rotations.matrix(orientation), local))
