"""Nearest and extreme points of a polytope { x : low <= c + N x <= high } by dual active-set methods."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.arrays import real, reals
from cdpr.native.bind import bind
from cdpr.native.compute import compute
from cdpr.tension.status import Status


def nearest_point(basis: ArrayLike, center: ArrayLike, low: ArrayLike, high: ArrayLike) -> tuple[Array, Array, Status]:
    """Return the x of least 2-norm with low <= c + N x <= high.

    Goldfarb and Idnani, Mathematical Programming 27 (1983).

    Args:
        basis: (m, r), N. Rows that are round-off must be zero.
        center: (m,), c.
        low: (m,), may be -inf.
        high: (m,), may be inf.

    Returns:
        x (r,) and c + N x (m,), which is exactly at the active limits; NaN unless the status is OK. The status: OK,
            INFEASIBLE if there is no such x, or NOT_FOUND.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> nearest_point([[1.0], [1.0]], [0.0, 0.0], [1.0, 2.0], [5.0, 5.0])
        (array([2.]), array([2., 2.]), <Status.OK: 0>)
    """
    return _point("nearest_point", basis, reals(center=center, low=low, high=high))


def extreme_point(
    objective: ArrayLike, basis: ArrayLike, center: ArrayLike, low: ArrayLike, high: ArrayLike
) -> tuple[Array, Array, Status]:
    """Return the x with low <= c + N x <= high that minimises g . x; of several, the one of least 2-norm.

    Mangasarian and Meyer, SIAM Journal on Control and Optimization 17 (1979).

    Args:
        objective: (r,), g.
        basis: (m, r), N. Rows that are round-off must be zero.
        center: (m,), c.
        low: (m,), may be -inf.
        high: (m,), may be inf.

    Returns:
        As `nearest_point`; the status is UNSUPPORTED if g . x has no minimum.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> extreme_point([-1.0], [[1.0], [1.0]], [0.0, 0.0], [1.0, 2.0], [5.0, 4.0])
        (array([4.]), array([4., 4.]), <Status.OK: 0>)
    """
    rows = reals(center=center, low=low, high=high)
    return _point("extreme_point", basis, rows, objective=real(objective, "objective"))


def extreme_tensions(basis: Array, center: Array, low: Array, high: Array) -> Array:
    """Return the smallest and largest tension of each cable, (m, 2), N, with low <= c + N x <= high.

    They are NaN if there are none. Arguments as in `extreme_point`.
    """
    m, r = basis.shape
    box, objective = np.array([center, low, high]), np.empty(r)
    point, work = np.empty(m), {"x": np.empty(r), "active": np.empty(m), "steps": np.empty(1)}
    call = bind("extreme_point", basis=basis, box=box, objective=objective, point=point, **work)
    found = np.full((m, 2), np.nan)
    for i, row in enumerate(basis):
        if not row.any():
            found[i] = min(max(center[i], low[i]), high[i])
            continue
        for side, sign in enumerate((1.0, -1.0)):
            np.multiply(row, sign, out=objective)
            if call() == Status.OK:
                found[i, side] = point[i]
    return found


def _point(operation: str, basis: ArrayLike, rows: dict[str, Array], **more: Array) -> tuple[Array, Array, Status]:
    N, box = real(basis, "basis"), np.stack(list(rows.values()))
    outputs = {"x": N.shape[1:], "point": box.shape[1:], "active": box.shape[1:], "steps": (1,)}
    code, (x, point, _, _) = compute(operation, {"basis": N, "box": box, **more}, outputs)
    status = Status(code)
    if status != Status.OK:
        x[:] = point[:] = np.nan
    return x, point, status
