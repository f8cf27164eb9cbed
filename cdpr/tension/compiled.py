"""Call of a compiled tension solver in null-space form with numpy arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.tension.status import Status


def distribute_once(
    operation: str, matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Return what an operation of the kernel library answers to one tension distribution problem.

    Args:
        operation: Name of the operation, such as "closed_form".
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.

    Returns:
        Tensions (m,) N, NaN unless the status is OK; and the status.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> distribute_once("closed_form", [[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    given = {"matrix": matrix, "wrench": wrench, "tension_min": tension_min, "tension_max": tension_max}
    arrays = {name: np.ascontiguousarray(value, dtype=np.float64) for name, value in given.items()}
    tension = np.empty(arrays["tension_min"].shape)
    status = Status(bind(operation, **arrays, tension=tension, status=np.empty(1))())
    if status != Status.OK:
        tension[:] = np.nan
    return tension, status
