"""Surface of a workspace: triangles between inside and outside cells."""

from __future__ import annotations

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.workspace.hull import Hull
from cdpr.analysis.workspace.result import Workspace
from cdpr.base.errors import CdprError
from cdpr.model.robot import Array

# Corners of a cube, and its six tetrahedra along the diagonal, which match those of adjacent cubes.
CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
TETRAHEDRA = [
    tuple(
        int(4 * step[0] + 2 * step[1] + step[2])
        for step in np.cumsum([[0, 0, 0], *np.eye(3, dtype=int)[list(way)]], axis=0)
    )
    for way in permutations(range(3))
]
# Minimum distance of the surface from a corner as a share of the edge, so that no triangle is degenerate.
NEAREST = 1e-3


def surface(found: Workspace) -> tuple[Array, NDArray[np.int64]]:
    """Return the closed surface of a workspace.

    Where values are known on both sides, the surface is at the linear interpolation of the edge between the centres of
    cells; otherwise half way. At the border of the box it is that border. (Marching tetrahedra: Doi and Koide, IEICE
    Trans. E74, 1991.)

    Returns:
        Corners (k, 3), m, and triangles (t, 3), anticlockwise from outside.

    Raises:
        CdprError: if the workspace is in a plane or along a line.
    """
    region = found.region
    if len(region.moving) < 3:
        raise CdprError(
            f"{found.robot}: a surface needs a workspace with three directions, this one has {len(region.moving)}"
        )
    if isinstance(found.detail, Hull):
        return found.detail.corners, found.detail.triangles.astype(np.int64)
    inside = np.pad(found.inside, 1)
    above = np.pad(found.value - (found.question.at_least or 0.0), 1, constant_values=np.nan)
    axes = [
        np.concatenate([[2.0 * low - axis[0]], axis, [2.0 * high - axis[-1]]])
        for axis, low, high in zip(region.axes, region.lower, region.upper, strict=True)
    ]
    shape = inside.shape
    number = np.arange(inside.size).reshape(shape)
    cubes = number[:-1, :-1, :-1].ravel()
    steps = CORNERS @ np.array([shape[1] * shape[2], shape[2], 1])
    here = inside.ravel()
    mixed = np.zeros(len(cubes), dtype=np.int64)
    for step in steps:
        mixed += here[cubes + step]
    cubes = cubes[(mixed > 0) & (mixed < len(steps))]
    edges = np.concatenate([_cut(here, cubes, steps, corners) for corners in TETRAHEDRA])
    ends, which = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    places = np.stack([axis[i] for axis, i in zip(axes, np.unravel_index(ends, shape), strict=True)], axis=-1)
    first, second = above.ravel()[ends].T
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where((first > 0.0) & (second < 0.0), first / (first - second), 0.5)
    share = np.clip(share, NEAREST, 1.0 - NEAREST)[:, None]
    return (1.0 - share) * places[:, 0] + share * places[:, 1], which.reshape(-1, 3)


def _cut(
    here: NDArray[np.bool_], cubes: NDArray[np.int64], steps: Array, corners: tuple[int, ...]
) -> NDArray[np.int64]:
    """Return triangles (t, 3, 2) of one tetrahedron of each cube, by the edges of their corners: inside, outside."""
    nodes = cubes[:, None] + steps[list(corners)].astype(np.int64)
    case = here[nodes] @ np.array([1, 2, 4, 8])
    turned = np.linalg.det(np.diff(CORNERS[list(corners)], axis=0)) < 0.0
    found = [np.empty((0, 3, 2), dtype=np.int64)]
    for number in range(1, 15):
        chosen = nodes[case == number]
        if not len(chosen):
            continue
        within = [i for i in range(4) if number >> i & 1]
        without = [i for i in range(4) if not number >> i & 1]
        order = [*within, *without]
        if len(within) == 1:
            a, b, c, d = order
            triangles = [[(a, b), (a, c), (a, d)]]
        elif len(within) == 3:
            a, b, c, d = order
            triangles = [[(a, d), (b, d), (c, d)]]
        else:
            a, b, c, d = order
            triangles = [[(a, c), (a, d), (b, d)], [(a, c), (b, d), (b, c)]]
        flipped = turned != _odd(order)
        for triangle in triangles:
            ends = np.stack([chosen[:, edge] for edge in map(list, triangle)], axis=1)
            found.append(ends[:, ::-1] if flipped else ends)
    return np.concatenate(found)


def _odd(order: list[int]) -> bool:
    """Return True if this permutation of 0, 1, 2, 3 is odd."""
    return sum(order[i] > order[j] for i in range(4) for j in range(i + 1, 4)) % 2 == 1
