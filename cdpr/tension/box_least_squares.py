"""The tensions within the limits that come nearest to a wrench: what remains when no distribution is admissible."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
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
    """Compute the tensions within the limits that minimise |D (W t - wrench)|; of several, the least.

    Stark and Parker, Computational Statistics 10 (1995).

    Args:
        matrix: (n, m), rows of the wrench matrix W, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N, may be inf.
        weights: (n,), the diagonal of D: 1 for forces, 1 / characteristic length, 1/m, for moments.
        operation: "best_effort": first ask for the least tensions that balance the wrench, and say whether they do.

    Returns:
        Tensions (m,) N, NaN where there are none. The status: OK, NOT_FOUND, or UNSUPPORTED where a lower limit is
        infinite; of "best_effort", also INFEASIBLE, with the nearest tensions, and BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> nearest_wrench_tension([[1.0, -1.0]], [20.0], [1.0, 1.0], [9.0, 9.0], [1.0])
        (array([9., 1.]), <Status.OK: 0>)
    """
    given = {"matrix": matrix, "wrench": wrench, "tension_min": tension_min, "tension_max": tension_max}
    arrays = {name: np.array(value, dtype=np.float64) for name, value in (given | {"weights": weights}).items()}
    tension = np.full(arrays["tension_min"].shape, np.nan)
    status = Status(bind(operation, **arrays, tension=tension, status=np.empty(1), steps=np.empty(1))())
    if status not in (Status.OK, Status.INFEASIBLE):
        tension[:] = np.nan
    return tension, status
