"""Convex hulls of points in space, from the farthest point to the next, and looked at when they are done.

After Barber, Dobkin and Huhdanpaa, "The quickhull algorithm for convex hulls", ACM TOMS 22(4), 1996.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array

# Of its size: a point that stands out by less adds nothing to a hull. Files of triangles hold 7 digits, so that flat
# faces are rough below that; and faces whose corners stand out by more have normals that are sharp to 9 digits.
FLAT = 1e-6
# Of its size: a point that is below a face, or above it by less, is below it: round-off of a distance.
BELOW = 1e-12
# Of its size: no corner of a hull may be above a face by more.
SOUND = 1e-9

MOST_CORNERS = 256  # of a hull: distances from it take time in proportion

PIECE = 4096  # points that are looked at together

Indices = NDArray[np.int64]


def convex_hull(points: Array, check: Callable[[], None] = lambda: None) -> tuple[Array, Indices]:
    """Return the corners (k, 3) of the convex hull of points (n, 3), of these, and its triangles (t, 3), outwards.

    Points that stand out by less than `FLAT` of the size are left out. Raises ValueError where all points lie in a
    plane, where the corners are more than `MOST_CORNERS`, and where round-off leaves no sound hull,
    and whatever `check` raises, which is called for each corner.
    """
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    flat = FLAT * size
    faces = _simplex(points, flat)
    normals, heights = _planes(points, faces)
    alive = np.ones(len(faces), dtype=bool)
    away = np.linalg.norm(points - points[faces[0]].mean(axis=0), axis=1)

    def outside(which: Indices, of: Indices) -> tuple[Indices, Indices, Array]:
        """Those of the points that stand out of one of these faces, out of which the most, and by how much."""
        above = points[which] @ normals[of].T - heights[of]
        best = np.argmax(above, axis=1)
        most = above[np.arange(len(which)), best]
        out = most > flat
        return which[out], of[best[out]], most[out]

    left, over, far = outside(np.arange(len(points)), np.arange(len(faces)))
    while len(left):
        check()
        # Of the farthest those at the rim: between them are others that would be no corners in the end.
        point = int(left[np.argmax(np.where(far >= far.max() - flat, away[left], -1.0))])
        seen = alive & (normals @ points[point] - heights > BELOW * size)
        rim = _rim(faces[seen])
        fresh = np.column_stack([rim, np.full(len(rim), point)])
        if np.count_nonzero(alive) - np.count_nonzero(seen) + len(fresh) > 2 * MOST_CORNERS - 4:  # of so many corners
            raise ValueError(f"its convex hull has more than {MOST_CORNERS} corners: draw a coarser one")
        count, alive = len(faces), np.concatenate([alive & ~seen, np.ones(len(fresh), dtype=bool)])
        faces = np.concatenate([faces, fresh])
        normals, heights = (
            np.concatenate(pair) for pair in zip((normals, heights), _planes(points, fresh), strict=True)
        )
        # What stood out of a face that is no more stands out of one of those in its place, or not at all.
        lost = seen[over]
        moved = outside(left[lost], np.arange(count, len(faces)))
        left, over, far = (np.concatenate([old[~lost], new]) for old, new in zip((left, over, far), moved, strict=True))
    used, triangles = np.unique(faces[alive], return_inverse=True)
    corners, triangles = points[used], triangles.reshape(-1, 3)
    if not _closed(triangles) or not (corners @ normals[alive].T - heights[alive] <= SOUND * size).all():
        raise ValueError("round-off leaves no convex hull: draw one without narrow triangles")
    return corners, triangles


def deepest(points: Array, corners: Array, triangles: Indices) -> float:
    """Return how deep within a hull the deepest of points (n, 3) is; 0 where all are on its surface."""
    normals, heights = _planes(corners, triangles)
    parts = [points[start : start + PIECE] for start in range(0, len(points), PIECE)]
    return max(0.0, *(float((heights - part @ normals.T).min(axis=1).max()) for part in parts))


def _simplex(points: Array, flat: float) -> Indices:
    """The faces of a tetrahedron of four points far from each other, outwards."""
    low = int(np.argmin(points[:, 0])) if len(points) else 0
    picked = [low]
    if len(points) > 3 and flat > 0.0:
        picked.append(int(np.argmax(np.linalg.norm(points - points[low], axis=1))))
        along = points[picked[1]] - points[low]
        away = np.linalg.norm(np.cross(points - points[low], along), axis=1) / np.linalg.norm(along)
        picked.append(int(np.argmax(away)))
        if away[picked[2]] > flat:
            normal = np.cross(along, points[picked[2]] - points[low])
            height = (points - points[low]) @ normal / np.linalg.norm(normal)
            picked.append(int(np.argmax(np.abs(height))))
            if abs(height[picked[3]]) > flat:
                a, b, c, d = picked if height[picked[3]] < 0.0 else (picked[0], picked[2], picked[1], picked[3])
                return np.array([(a, b, c), (a, d, b), (b, d, c), (c, d, a)])
    raise ValueError("it has no volume: all its corners lie in a plane")


def _planes(points: Array, faces: Indices) -> tuple[Array, Array]:
    """Unit normals (t, 3), outwards, and heights (t,) of the planes of faces."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return normals, np.einsum("ij,ij->i", normals, (a + b + c) / 3.0)


def _rim(faces: Indices) -> Indices:
    """The edges (k, 2) of some faces that belong to one of them alone, in its direction."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    reverse = {(b, a) for a, b in edges.tolist()}
    return np.array([edge for edge in edges.tolist() if tuple(edge) not in reverse], dtype=np.int64).reshape(-1, 2)


def _closed(triangles: Indices) -> bool:
    """Whether each edge belongs to two triangles, once in each direction."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).tolist()
    pairs = {(a, b) for a, b in edges}
    return len(pairs) == len(edges) and all((b, a) in pairs for a, b in pairs)
