"""Tensions closest to a target for many cables: Newton's method on the few equations instead of the many cables."""

from __future__ import annotations

from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


def nearest_tension_by_rows(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike, target: ArrayLike
) -> tuple[Array, Status]:
    """Return the admissible tensions closest to a target, by Newton's method in the row space of W.

    Qi and Sun, Mathematical Programming 58 (1993). For many cables: a step takes n^2 m operations.

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m, required wrench of the cables.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable with equal limits is locked at that tension.
        target: (m,) N.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, INFEASIBLE, NOT_FOUND if this method cannot
            decide, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> nearest_tension_by_rows([[1.0, -1.0, 1.0]], [3.0], [1.0] * 3, [9.0] * 3, [1.0] * 3)[1]
        <Status.OK: 0>
    """
    return distribute_once("nearest_by_rows", matrix, wrench, tension_min, tension_max, target=target)
