"""Compiled cubic B-splines that follow polygons within a tolerance.

The control points lie on the polygon at the means of three knots each (Schoenberg's variation-diminishing spline, de
Boor 1978, chapter XI), or in curves as far outside as makes parabolas exact. So straight stretches stay exact, and wide
spans average the zigzag of many short chords.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.model.robot import Array
from cdpr.native.arrays import reals, whole
from cdpr.native.bind import bind

Indices = NDArray[np.int64]


def polygon_splines(
    points: ArrayLike,
    chord: ArrayLike,
    turn: ArrayLike,
    wanted: ArrayLike,
    allowed: ArrayLike,
    tolerance: ArrayLike,
    missing: ArrayLike,
    parted: ArrayLike,
    runs: ArrayLike,
) -> tuple[Array, Indices]:
    """Return a smooth curve along each polygon; the M vertices of all polygons are concatenated.

    Args:
        points: (M, 3) m, the vertices of all.
        chord: (M,) m, length of the chord before each; ignored at the first vertex of a polygon.
        turn: (M,) change of direction at each, as the norm of the difference of unit vectors.
        wanted: (M,) m, the width that each corner needs for its speed; 0 at ends.
        allowed: (M,) m, the largest width of each.
        tolerance: (M,) m, of the chord after each vertex.
        missing: (M,) m, allowed distance of the curve from each vertex.
        parted: (M,) bool, True for vertices at which a piece must end.
        runs: (R + 1,) the first vertex of each polygon, and M; each has two or more.

    Returns:
        Pieces (P, 16): begin and end, m; position, and first and second derivative there; second derivative at the end;
            the chord that it follows, counted within its polygon; the length of its span, m. The first piece of each
            polygon, and P, (R + 1,): a polygon has none if chords are too short to round each corner within its own.

    Raises:
        ValueError: if the shapes do not match, or the runs are not those of M vertices.

    Example:
        >>> corner = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]
        >>> chord, turn, width, loose = [0.0, 1.0, 1.0], [0.0, 1.41, 0.0], [0.0, 0.1, 0.0], [0.05] * 3
        >>> pieces, rows = polygon_splines(corner, chord, turn, width, [0.2] * 3, loose, loose, [False] * 3, [0, 3])
        >>> rows, pieces[:, 0]
        (array([0, 4]), array([0. , 0.9, 1. , 1.1]))
    """
    arrays = reals(points=points, turn=turn, tolerance=tolerance, missing=missing)
    changed = reals(chord=chord, wanted=wanted, allowed=allowed)
    arrays |= {"way" if name == "chord" else name: array.copy() for name, array in changed.items()}
    ends, first = whole(parted, "parted"), whole(runs, "runs")
    vertices = arrays["turn"].size
    if first.ndim != 1 or first.size < 2 or first[0] != 0 or first[-1] != vertices or (np.diff(first) < 2).any():
        raise ValueError(f"polygon_splines: runs: expected numbers from 0 to {vertices}, 2 or more apart, got {first}.")
    count, longest = len(first) - 1, int(np.diff(first).max())
    pieces, rows = np.empty((7 * vertices, 16)), np.empty(count + 1, dtype=np.int64)
    numbers = {"r": count, "longest": longest}
    bind("polygon_splines", **arrays, **numbers, parted=ends, runs=first, pieces=pieces, rows=rows)()
    return pieces[: rows[-1]], rows
