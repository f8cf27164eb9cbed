"""Tensions within the limits closest to a wrench: the fallback if no distribution is admissible."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.arrays import reals
from cdpr.native.bind import bind
from cdpr.tension.status import Status


def nearest_wrench_tension(
    matrix: ArrayLike,
    wrench: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    weights: ArrayLike,
    operation: str = "box_least_squares",
) -> tuple[Array, Status]:
    """Return the tensions within the limits that minimise |D (W t - wrench)|; of several, those of least norm.

    Stark and Parker, Computational Statistics 10 (1995).

    Args:
        matrix: (n, m), rows of the wrench matrix W, moments about the platform's origin, world axes.
        wrench: (n,), N and N m, required wrench of the cables.
        tension_min: (m,) N.
        tension_max: (m,) N, may be inf.
        weights: (n,), diagonal of D: 1 for forces, 1 / characteristic length, 1/m, for moments.
        operation: "best_effort" first computes the least tensions that balance the wrench, and reports if they do.

    Returns:
        Tensions (m,) N, NaN if there are none. The status: OK, NOT_FOUND, or UNSUPPORTED if a lower limit is infinite;
            for "best_effort" also INFEASIBLE, with the nearest tensions, and BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> nearest_wrench_tension([[1.0, -1.0]], [20.0], [1.0, 1.0], [9.0, 9.0], [1.0])
        (array([9., 1.]), <Status.OK: 0>)
    """
    arrays = reals(matrix=matrix, wrench=wrench, tension_min=tension_min, tension_max=tension_max, weights=weights)
    tension = np.full(arrays["tension_min"].shape, np.nan)
    status = Status(bind(operation, **arrays, tension=tension, status=np.empty(1), steps=np.empty(1))())
    if status not in (Status.OK, Status.INFEASIBLE):
        tension[:] = np.nan
    return tension, status
