"""Boundary of a workspace as seen from a point inside: a closed mesh with its corners on rays from that point.

Along each ray, the boundary is the first point at which the value falls below the edge. The mesh is the complete
workspace if that is star-shaped with respect to the point. The degree of this is reported as the share of inside
positions that are visible from the point.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.workspace.octree import CellResults
from cdpr.analysis.workspace.regions import Region
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.model.robot import Array

RAYS = 2562  # default: a volume error of a hundredth for curved boundaries
MOST_RAYS = 10**6
MARCH = 4  # steps along a ray to bracket the boundary
NARROWINGS = 8  # iterations of false position within that step
ENOUGH = 1e-4  # tolerance of the boundary as a share of the region's diagonal
SEEN = 16  # samples on the line to a position to test its visibility
VIEWED = 1000  # maximum number of tested positions

Triangles = NDArray[np.integer[Any]]


@dataclass(frozen=True, eq=False)
class Hull:
    """Boundary mesh.

    Attributes:
        centre: (3,), m, origin of the rays.
        corners: (k, 3), m; empty if nothing is inside.
        triangles: (t, 3), indices of corners, anticlockwise from outside; edges (t, 2) in a plane, ends (2, 1) along a
            line.
        evaluated: number of evaluated positions.
        seen: share of the inside positions that are visible from the centre.
    """

    centre: Array
    corners: Array
    triangles: Triangles
    evaluated: int
    seen: float

    @property
    def volume(self) -> float:
        """Enclosed size, m^3, m^2 or m."""
        if not len(self.corners):
            return 0.0
        ends = self.corners[self.triangles] - self.centre
        if ends.shape[1] == 1:
            return float(np.linalg.norm(ends, axis=2).sum())
        if ends.shape[1] == 2:
            return float(0.5 * np.linalg.norm(np.cross(ends[:, 0], ends[:, 1]), axis=1).sum())
        return float(np.einsum("ij,ij->i", ends[:, 0], np.cross(ends[:, 1], ends[:, 2])).sum() / 6.0)

    def figures(self) -> dict[str, Any]:
        """Return its figures."""
        return {
            "rays": len(self.corners),
            "asked": self.evaluated,
            "star_shaped": self.seen,
            "centre": self.centre.tolist(),
        }

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return its data as arrays for a file."""
        figures = np.array([float(self.evaluated), self.seen])
        named = {"centre": self.centre, "corners": self.corners, "triangles": self.triangles, "figures": figures}
        return {f"hull_{name}": array for name, array in named.items()}

    @classmethod
    def from_plain(cls, region: Region, arrays: dict[str, NDArray[Any]]) -> Hull:
        """Return the hull from the arrays of `plain`."""
        centre, corners, triangles, figures = (
            arrays[f"hull_{name}"] for name in ("centre", "corners", "triangles", "figures")
        )
        return cls(centre, corners, triangles, int(figures[0]), float(figures[1]))


def hull(
    evaluate: Callable[[Array], CellResults],
    region: Region,
    edge: float,
    home: Array,
    cells: CellResults,
    rays: int,
    progress: Callable[[int, int], None],
) -> Hull:
    """Return the boundary as seen from the home pose or, if that is not inside, from the cell of the greatest value.

    Args:
        evaluate: function that evaluates positions (n, 3).
        region: region that limits the rays.
        edge: value between inside and outside.
        home: (3,), m.
        cells: results of the region's cells.
        rays: minimum number of rays.
        progress: called with the number of finished rounds and their total.

    Raises:
        CdprError: if `rays` is out of range.
    """
    if not 4 <= rays <= MOST_RAYS:
        raise CdprError(f"rays: expected a whole number from 4 to {MOST_RAYS}, got {shown(rays)}")
    within = bool(((home >= region.lower) & (home <= region.upper)).all())
    if within and evaluate(home[None]).inside[0]:
        centre = home
    elif cells.inside.any():
        best = np.argmax(np.where(cells.inside, np.nan_to_num(cells.value, nan=-np.inf), -np.inf))
        centre = region.positions(np.array([best]))[0]
    else:
        dimensions = len(region.moving)
        return Hull(home, np.empty((0, 3)), np.empty((0, dimensions), dtype=np.int64), 1, 0.0)
    directions, triangles = _directions(region, rays)
    evaluated = 1

    def inside(positions: Array) -> tuple[Array, NDArray[np.bool_]]:
        nonlocal evaluated
        evaluated += len(positions)
        found = evaluate(np.clip(positions, region.lower, region.upper))
        return np.where(np.isnan(found.value), -np.inf, found.value - edge), found.inside

    with np.errstate(divide="ignore", invalid="ignore"):
        ahead = np.where(directions > 0.0, region.upper - centre, region.lower - centre) / directions
    length = np.where(directions == 0.0, np.inf, ahead).min(axis=1)
    share = _leaves(centre, directions * length[:, None], length, inside, region, progress)
    corners = centre + directions * (share * length)[:, None]
    seen = _seen(centre, region, cells, inside)
    return Hull(np.array(centre), corners, triangles, evaluated, seen)


def _leaves(
    centre: Array,
    ways: Array,
    length: Array,
    inside: Callable[[Array], tuple[Array, NDArray[np.bool_]]],
    region: Region,
    progress: Callable[[int, int], None],
) -> Array:
    """Return the share of each vector (n, 3) from the centre to the border, with these lengths, at which it leaves."""
    n = len(ways)
    low, high = np.zeros(n), np.ones(n)
    below, above = np.full(n, np.inf), np.full(n, np.nan)  # values at high (outside) and at low (inside)
    going = np.ones(n, dtype=bool)
    for k in range(1, MARCH + 1):
        step = k / MARCH
        value, here = inside(centre + step * ways[going])
        index = np.flatnonzero(going)
        low[index[here]], above[index[here]] = step, value[here]
        high[index[~here]], below[index[~here]] = step, value[~here]
        going[index[~here]] = False
        progress(k, MARCH + NARROWINGS)
    left = ~going  # the others are inside up to the border
    low[going] = high[going] = 1.0
    near = ENOUGH * float(np.linalg.norm(region.upper - region.lower))
    for k in range(NARROWINGS):
        open_ = np.flatnonzero(left & ((high - low) * length > near))
        if not len(open_):
            break
        a, b = above[open_], below[open_]
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.where(np.isfinite(a) & np.isfinite(b) & (a > 0.0) & (b < 0.0) & (k % 3 < 2), a / (a - b), 0.5)
        at = low[open_] + np.clip(share, 0.02, 0.98) * (high - low)[open_]
        value, here = inside(centre + at[:, None] * ways[open_])
        low[open_[here]], above[open_[here]] = at[here], value[here]
        high[open_[~here]], below[open_[~here]] = at[~here], value[~here]
        progress(MARCH + k + 1, MARCH + NARROWINGS)
    with np.errstate(invalid="ignore", divide="ignore"):
        known = (above >= 0.0) & (below <= 0.0) & np.isfinite(above - below) & (above > below)
        share = np.where(known, above / (above - below), 0.5)
    return np.where(left, low + share * (high - low), 1.0)


def _seen(
    centre: Array, region: Region, cells: CellResults, inside: Callable[[Array], tuple[Array, NDArray[np.bool_]]]
) -> float:
    """Return the share of evenly sampled inside cells whose straight line to the centre is inside."""
    there = np.flatnonzero(cells.inside)
    if not len(there):
        return 1.0
    chosen = there[np.linspace(0, len(there) - 1, min(VIEWED, len(there))).astype(np.int64)]
    shares = (np.arange(1, SEEN) / SEEN)[None, :, None]
    ways = centre + shares * (region.positions(chosen) - centre)[:, None]
    _, here = inside(ways.reshape(-1, 3))
    return float(here.reshape(len(chosen), -1).all(axis=1).mean())


def _directions(region: Region, rays: int) -> tuple[Array, Triangles]:
    """Return unit vectors (k, 3), spaced in proportion to the sides of the region, and the faces between them."""
    moving = region.moving
    directions: Array
    if len(moving) == 1:
        directions, faces = np.zeros((2, 3)), np.array([[0], [1]])
        directions[:, moving[0]] = (1.0, -1.0)
        return directions, faces
    if len(moving) == 2:
        angles = 2.0 * np.pi * np.arange(rays) / rays
        directions = np.zeros((rays, 3))
        directions[:, moving[0]], directions[:, moving[1]] = np.cos(angles), np.sin(angles)
        faces = np.stack([np.arange(rays), (np.arange(rays) + 1) % rays], axis=1)
    else:
        directions, faces = _geodesic(max(1, int(np.ceil(np.sqrt((rays - 2) / 10.0)))))
    directions = directions * np.where(region.upper > region.lower, region.upper - region.lower, 1.0)
    return directions / np.linalg.norm(directions, axis=1)[:, None], faces


def _geodesic(frequency: int) -> tuple[Array, Triangles]:
    """Return corners (10 f^2 + 2, 3) and triangles of an icosahedron with edges divided by f, on the unit sphere."""
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    corners = [(0.0, s, t * golden) for s in (-1, 1) for t in (-1, 1)]
    base = np.array([np.roll(corner, k) for k in range(3) for corner in corners])
    gaps = np.linalg.norm(base[:, None] - base[None], axis=2)
    near = (gaps > 0.1) & (gaps < 2.1)
    triples = [
        (i, j, k) for i in range(12) for j in range(i) for k in range(j) if near[i, j] and near[j, k] and near[i, k]
    ]
    steps = [(a, b) for a in range(frequency + 1) for b in range(frequency + 1 - a)]
    points: list[Array] = []
    faces = []
    for i, j, k in triples:
        if np.dot(base[i], np.cross(base[j], base[k])) < 0.0:
            j, k = k, j
        first = len(points) * len(steps)
        number = {step: first + n for n, step in enumerate(steps)}
        shares = np.array(steps) / frequency
        points.append(base[i] + shares[:, :1] * (base[j] - base[i]) + shares[:, 1:] * (base[k] - base[i]))
        for a, b in steps:
            if a + b < frequency:
                faces.append((number[a, b], number[a + 1, b], number[a, b + 1]))
            if a + b < frequency - 1:
                faces.append((number[a + 1, b], number[a + 1, b + 1], number[a, b + 1]))
    every = np.concatenate(points)
    every /= np.linalg.norm(every, axis=1)[:, None]
    # equal corners of several triangles differ only by rounding
    _, first_of, which = np.unique(np.round(every, 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    return every[first_of], which.reshape(-1)[np.array(faces)]
