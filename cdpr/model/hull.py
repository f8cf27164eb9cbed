"""Convex hulls of points in space by quickhull, with a final check.

Source: Barber, Dobkin and Huhdanpaa, "The quickhull algorithm for convex hulls", ACM TOMS 22(4), 1996.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array

# Share of the size: points that protrude less are ignored. Triangle files have 7 digits, so that flat faces are rough
# below that; faces with corners that protrude more have normals with 9 exact digits.
FLAT = 1e-6
# Share of the size: points less than this above a face count as below it, because of round-off.
BELOW = 1e-12
# Share of the size: largest height of a corner above a face of a valid hull.
SOUND = 1e-9

MOST_CORNERS = 256  # of a hull; the time of distance computations is proportional

PIECE = 4096  # points per batch

Indices = NDArray[np.int64]


def convex_hull(points: Array, check: Callable[[], None] = lambda: None) -> tuple[Array, Indices]:
    """Return the corners (k, 3) of the convex hull of points (n, 3), a subset, and its triangles (t, 3), outwards.

    Points that protrude by less than `FLAT` of the size are ignored. `check` is called for each corner; it may raise to
    cancel.

    Raises:
        ValueError: if all points lie in a plane, there are more than `MOST_CORNERS` corners, or round-off prevents a
            valid hull.
    """
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    flat = FLAT * size
    faces = _simplex(points, flat)
    normals, heights = _planes(points, faces)
    alive = np.ones(len(faces), dtype=bool)
    away = np.linalg.norm(points - points[faces[0]].mean(axis=0), axis=1)

    def outside(which: Indices, of: Indices) -> tuple[Indices, Indices, Array]:
        """Return the points outside one of these faces, the face that each exceeds most, and by how much."""
        above = points[which] @ normals[of].T - heights[of]
        best = np.argmax(above, axis=1)
        most = above[np.arange(len(which)), best]
        out = most > flat
        return which[out], of[best[out]], most[out]

    left, over, far = outside(np.arange(len(points)), np.arange(len(faces)))
    while len(left):
        check()
        # Of the farthest points, those at the rim: points between them would be no corners in the end.
        point = int(left[np.argmax(np.where(far >= far.max() - flat, away[left], -1.0))])
        seen = alive & (normals @ points[point] - heights > BELOW * size)
        rim = _rim(faces[seen])
        fresh = np.column_stack([rim, np.full(len(rim), point)])
        if (
            np.count_nonzero(alive) - np.count_nonzero(seen) + len(fresh) > 2 * MOST_CORNERS - 4
        ):  # for this many corners
            raise ValueError(f"its convex hull has more than {MOST_CORNERS} corners: draw a coarser one")
        count, alive = len(faces), np.concatenate([alive & ~seen, np.ones(len(fresh), dtype=bool)])
        faces = np.concatenate([faces, fresh])
        normals, heights = (
            np.concatenate(pair) for pair in zip((normals, heights), _planes(points, fresh), strict=True)
        )
        # Points outside a removed face are outside a new face, or inside the hull.
        lost = seen[over]
        moved = outside(left[lost], np.arange(count, len(faces)))
        left, over, far = (np.concatenate([old[~lost], new]) for old, new in zip((left, over, far), moved, strict=True))
    used, triangles = np.unique(faces[alive], return_inverse=True)
    corners, triangles = points[used], triangles.reshape(-1, 3)
    if not _closed(triangles) or not (corners @ normals[alive].T - heights[alive] <= SOUND * size).all():
        raise ValueError("round-off leaves no convex hull: draw one without narrow triangles")
    return corners, triangles


def deepest(points: Array, corners: Array, triangles: Indices) -> float:
    """Return the depth of the deepest of points (n, 3) within a hull; 0 if all are on its surface."""
    normals, heights = _planes(corners, triangles)
    parts = [points[start : start + PIECE] for start in range(0, len(points), PIECE)]
    return max(0.0, *(float((heights - part @ normals.T).min(axis=1).max()) for part in parts))


def _simplex(points: Array, flat: float) -> Indices:
    """Return the faces of a tetrahedron of four distant points, outwards."""
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
    """Return unit normals (t, 3), outwards, and heights (t,) of the planes of faces."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return normals, np.einsum("ij,ij->i", normals, (a + b + c) / 3.0)


def _rim(faces: Indices) -> Indices:
    """Return the edges (k, 2) that belong to exactly one of the faces, in its direction."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    reverse = {(b, a) for a, b in edges.tolist()}
    return np.array([edge for edge in edges.tolist() if tuple(edge) not in reverse], dtype=np.int64).reshape(-1, 2)


def _closed(triangles: Indices) -> bool:
    """Return True if each edge belongs to two triangles, once in each direction."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).tolist()
    pairs = {(a, b) for a, b in edges}
    return len(pairs) == len(edges) and all((b, a) in pairs for a, b in pairs)
