"""Platform shapes as triangle meshes and outlines."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array

SIDES = 48  # per circle
RINGS = 24  # per sphere, from pole to pole

CUBE = np.array(list(product((-0.5, 0.5), repeat=3)))
EDGES = [(i, j) for i in range(8) for j in range(i) if np.abs(CUBE[i] - CUBE[j]).sum() == 1.0]
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))  # counter-clockwise


@dataclass(frozen=True, eq=False)
class Solid:
    """Convex solid in the platform's axes."""

    vertices: Array  # (v, 3), m
    triangles: NDArray[np.int32]  # (t, 3), counter-clockwise as seen from outside
    faces: tuple[tuple[int, ...], ...]  # corners of the flat faces in order, drawn as edges
    curved: bool = False  # True if the surface has curved parts


def solid(shape: dict[str, Any] | None) -> Solid | None:
    """Return the solid of a shape in the format of `Platform.outline`, or None; for a mesh, its bounding box."""
    if not shape:
        return None
    (kind, size), *_ = shape.items()
    if kind == "cylinder":
        return _cylinder(*size)
    if kind == "sphere":
        return _sphere(float(size))
    lower, upper = np.array(size if kind == "mesh" else np.outer((-0.5, 0.5), size), dtype=float)
    return _box(0.5 * (lower + upper), upper - lower)


def _box(middle: Array, size: Array) -> Solid:
    triangles = [corner for a, b, c, d in FACES for corner in ((a, b, c), (a, c, d))]
    return Solid(middle + CUBE * size, np.array(triangles, np.int32), FACES)


def _cylinder(radius: float, height: float) -> Solid:
    angle = np.arange(SIDES) * (2.0 * np.pi / SIDES)
    circle = radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(SIDES)], axis=1)
    up = np.array([0.0, 0.0, 0.5 * height])
    vertices = np.concatenate([circle - up, circle + up])
    triangles: list[tuple[int, int, int]] = []
    for i in range(SIDES):
        j = (i + 1) % SIDES
        triangles += [(i, j, SIDES + j), (i, SIDES + j, SIDES + i)]
        if 0 < i < SIDES - 1:
            triangles += [(0, i + 1, i), (SIDES, SIDES + i, SIDES + i + 1)]
    rims = (tuple(reversed(range(SIDES))), tuple(range(SIDES, 2 * SIDES)))
    return Solid(vertices, np.array(triangles, np.int32), rims, curved=True)


def _sphere(radius: float) -> Solid:
    polar = np.arange(1, RINGS) * (np.pi / RINGS)
    angle = np.arange(SIDES) * (2.0 * np.pi / SIDES)
    across, up = np.sin(polar)[:, None], np.cos(polar)[:, None]
    rings = np.stack(np.broadcast_arrays(across * np.cos(angle), across * np.sin(angle), up), axis=2)
    poles = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    top, bottom = (RINGS - 1) * SIDES, (RINGS - 1) * SIDES + 1
    triangles: list[tuple[int, int, int]] = []
    for i in range(SIDES):
        j, last = (i + 1) % SIDES, (RINGS - 2) * SIDES
        triangles += [(top, i, j), (bottom, last + j, last + i)]
        for k in range(0, last, SIDES):
            triangles += [(k + i, k + SIDES + i, k + SIDES + j), (k + i, k + SIDES + j, k + j)]
    return Solid(radius * np.concatenate([rings.reshape(-1, 3), poles]), np.array(triangles, np.int32), (), curved=True)


def radius_around(shape: dict[str, Any] | None, anchors: Array) -> float:
    """Return the radius (m) of a sphere about the platform's origin that contains shape and anchors (m, 3)."""
    corners = anchors
    body = solid(shape)
    if body is not None:
        corners = np.concatenate([anchors, body.vertices])
    return float(np.linalg.norm(corners, axis=1).max())


def world_origin(fixed: Array) -> Array:
    """Return the world's origin (1, 3), to be kept in view with the fixed points (k, 3), m.

    Return an empty array (0, 3) if the origin is so far away that the robot would appear small. For planar robots,
    return its projection onto their plane.
    """
    low, high = fixed.min(axis=0), fixed.max(axis=0)
    size = float(np.linalg.norm(high - low))
    origin = np.where(high - low < 1e-6 * size, low, 0.0)
    near = float(np.linalg.norm(origin - 0.5 * (low + high))) <= size
    return origin[None] if near else np.empty((0, 3))
