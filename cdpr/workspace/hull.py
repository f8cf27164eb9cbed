"""The boundary of a workspace as seen from a point within it: a closed mesh whose corners lie on rays from there.

Along each ray the first place is looked for at which the value falls below the edge. That is all of the workspace where
it is star-shaped, seen from that point: each position in it is reached from there without leaving it. Whether it is, is
told as a share of positions that are inside.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.errors import CdprError
from cdpr.model.robot import Array
from cdpr.workspace.octree import Asked
from cdpr.workspace.regions import Region

RAYS = 2562  # unless said: a boundary a hundredth off in volume, where it is curved
MOST_RAYS = 10**6
MARCH = 4  # steps along a ray before the one in which it leaves is known
NARROWINGS = 8  # of that step, by false position
ENOUGH = 1e-4  # share of the region's diagonal to which a boundary is known
SEEN = 16  # places on the way to a position that tell whether it can be seen
VIEWED = 1000  # positions, at most

Triangles = NDArray[np.integer[Any]]


@dataclass(frozen=True, eq=False)
class Hull:
    """A boundary.

    Attributes:
        centre: (3,), m, from where it is seen.
        corners: (k, 3), m; none where nothing is inside.
        triangles: (t, 3), of corners, anticlockwise as seen from outside; in a plane edges (t, 2), along a line
            ends (2, 1).
        asked: how many positions were asked.
        seen: share of the positions inside that are seen from the centre.
    """

    centre: Array
    corners: Array
    triangles: Triangles
    asked: int
    seen: float

    @property
    def volume(self) -> float:
        """What it encloses, m^3, m^2 or m."""
        if not len(self.corners):
            return 0.0
        ends = self.corners[self.triangles] - self.centre
        if ends.shape[1] == 1:
            return float(np.linalg.norm(ends, axis=2).sum())
        if ends.shape[1] == 2:
            return float(0.5 * np.linalg.norm(np.cross(ends[:, 0], ends[:, 1]), axis=1).sum())
        return float(np.einsum("ij,ij->i", ends[:, 0], np.cross(ends[:, 1], ends[:, 2])).sum() / 6.0)

    def told(self) -> dict[str, Any]:
        """Return its figures."""
        return {
            "rays": len(self.corners),
            "asked": self.asked,
            "star_shaped": self.seen,
            "centre": self.centre.tolist(),
        }

    def plain(self) -> dict[str, NDArray[Any]]:
        """Return it as arrays, which a file holds."""
        figures = np.array([float(self.asked), self.seen])
        named = {"centre": self.centre, "corners": self.corners, "triangles": self.triangles, "figures": figures}
        return {f"hull_{name}": array for name, array in named.items()}

    @classmethod
    def from_plain(cls, region: Region, arrays: dict[str, NDArray[Any]]) -> Hull:
        """Undo `plain`."""
        centre, corners, triangles, figures = (
            arrays[f"hull_{name}"] for name in ("centre", "corners", "triangles", "figures")
        )
        return cls(centre, corners, triangles, int(figures[0]), float(figures[1]))


def hull(
    ask: Callable[[Array], Asked],
    region: Region,
    edge: float,
    home: Array,
    cells: Asked,
    rays: int,
    progress: Callable[[int, int], None],
) -> Hull:
    """Return the boundary as seen from the home, or, where that is not inside, from the cell of the greatest value.

    Args:
        ask: answers positions (n, 3).
        region: beyond which nothing is looked for.
        edge: the value between inside and outside.
        home: (3,), m.
        cells: what is known of the region's cells.
        rays: how many, at least.
        progress: called with how many rounds are done, and of how many.

    Raises CdprError where `rays` makes no sense.
    """
    if not 4 <= rays <= MOST_RAYS:
        raise CdprError(f"rays: a whole number from 4 to {MOST_RAYS} is expected, got {rays!r}")
    within = bool(((home >= region.lower) & (home <= region.upper)).all())
    if within and ask(home[None]).inside[0]:
        centre = home
    elif cells.inside.any():
        best = np.argmax(np.where(cells.inside, np.nan_to_num(cells.value, nan=-np.inf), -np.inf))
        centre = region.positions(np.array([best]))[0]
    else:
        dimensions = len(region.moving)
        return Hull(home, np.empty((0, 3)), np.empty((0, dimensions), dtype=np.int64), 1, 0.0)
    directions, triangles = _directions(region, rays)
    asked = 1

    def inside(positions: Array) -> tuple[Array, NDArray[np.bool_]]:
        nonlocal asked
        asked += len(positions)
        found = ask(np.clip(positions, region.lower, region.upper))
        return np.where(np.isnan(found.value), -np.inf, found.value - edge), found.inside

    with np.errstate(divide="ignore", invalid="ignore"):
        ahead = np.where(directions > 0.0, region.upper - centre, region.lower - centre) / directions
    length = np.where(directions == 0.0, np.inf, ahead).min(axis=1)
    share = _leaves(centre, directions * length[:, None], length, inside, region, progress)
    corners = centre + directions * (share * length)[:, None]
    seen = _seen(centre, region, cells, inside)
    return Hull(np.array(centre), corners, triangles, asked, seen)


def _leaves(
    centre: Array,
    ways: Array,
    length: Array,
    inside: Callable[[Array], tuple[Array, NDArray[np.bool_]]],
    region: Region,
    progress: Callable[[int, int], None],
) -> Array:
    """Return at which share of the ways (n, 3) to the border, of these lengths, each leaves the inside."""
    n = len(ways)
    low, high = np.zeros(n), np.ones(n)
    below, above = np.full(n, np.inf), np.full(n, np.nan)  # values at high, outside, and at low, inside
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
    centre: Array, region: Region, cells: Asked, inside: Callable[[Array], tuple[Array, NDArray[np.bool_]]]
) -> float:
    """Share of the cells inside, of so many evenly drawn ones, to which the straight way from the centre is inside."""
    there = np.flatnonzero(cells.inside)
    if not len(there):
        return 1.0
    chosen = there[np.linspace(0, len(there) - 1, min(VIEWED, len(there))).astype(np.int64)]
    shares = (np.arange(1, SEEN) / SEEN)[None, :, None]
    ways = centre + shares * (region.positions(chosen) - centre)[:, None]
    _, here = inside(ways.reshape(-1, 3))
    return float(here.reshape(len(chosen), -1).all(axis=1).mean())


def _directions(region: Region, rays: int) -> tuple[Array, Triangles]:
    """Unit vectors (k, 3), as evenly as the sides of the region are long, and what they bound."""
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
    """Corners (10 f^2 + 2, 3) and triangles of an icosahedron whose edges are cut into f parts, on the unit sphere."""
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
    # The same corner, of several triangles, comes out equal to within some roundings.
    _, first_of, which = np.unique(np.round(every, 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    return every[first_of], which.reshape(-1)[np.array(faces)]
