"""Convex solids as rows of numbers for the kernel library (solids.hpp, hull.hpp).

The row of a solid is (11,): its kind, its centre (3,) [m], its attitude (4,) as a quaternion w, x, y, z, and its size
(3,) [m]. The size of a box is its half widths, that of a sphere its radius, and that of a cylinder its radius and half
height. The row of a convex hull is longer. Its size is the number of triangles, the number of edges and the radius of
the enclosing sphere. The normal (3,), height and corners (9,) of each triangle follow, then both ends (6,) of each
edge, all relative to the centre.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model import rotations
from cdpr.model.hull import convex_hull
from cdpr.model.robot import Array
from cdpr.model.shapes import Box, Cylinder, Hull, Mesh, Shape, Sphere

WIDTH = 11
BOX, SPHERE, CYLINDER, HULL = range(4)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def row(shape: Shape | Hull, position: ArrayLike = (0.0, 0.0, 0.0), attitude: Sequence[float] = UPRIGHT) -> Array:
    """Return the row of a shape at a position [m] and attitude; the bounding box of a mesh."""
    middle, kind, size, more = np.zeros(3), BOX, (0.0, 0.0, 0.0), np.zeros(0)
    if isinstance(shape, Box):
        x, y, z = shape.size
        size = (0.5 * x, 0.5 * y, 0.5 * z)
    elif isinstance(shape, Sphere):
        kind, size = SPHERE, (shape.radius, 0.0, 0.0)
    elif isinstance(shape, Cylinder):
        kind, size = CYLINDER, (shape.radius, 0.5 * shape.height, 0.0)
    elif isinstance(shape, Mesh):
        low, high = np.array(shape.lower), np.array(shape.upper)
        x, y, z = (0.5 * (high - low)).tolist()
        middle, size = 0.5 * (low + high), (x, y, z)
    elif isinstance(shape, Hull):
        kind, (middle, size, more) = HULL, _hull(np.array(shape.corners))
    turned = rotations.rotate(np.array([attitude], dtype=float), middle)[0]
    return np.concatenate([[kind], np.asarray(position) + turned, attitude, size, more])


def rows(solids: Sequence[Array]) -> Array:
    """Return the rows of several solids, (k, 11 or more), padded with zeros."""
    table = np.zeros((len(solids), max(map(len, solids), default=WIDTH)))
    for line, solid in zip(table, solids, strict=True):
        line[: len(solid)] = solid
    return table


def _hull(points: Array) -> tuple[Array, tuple[float, float, float], Array]:
    """Return the centre (3,), the size and the other numbers of the convex hull of points (k, 3)."""
    corners, triangles = convex_hull(points)
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    corners = corners - middle
    a, b, c = (corners[triangles[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    heights = np.max(corners @ normals.T, axis=0)  # above all corners, although faces are uneven by round-off
    edges = np.array([(i, j) for t in triangles.tolist() for i, j in zip(t, (t[1], t[2], t[0]), strict=True) if i < j])
    radius = float(np.linalg.norm(corners, axis=1).max())
    faces = np.column_stack([normals, heights, a, b, c])
    return middle, (len(faces), len(edges), radius), np.concatenate([faces.ravel(), corners[edges].ravel()])
