"""Compiled tension solvers in null-space form, and checks of their answers, with numpy arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.arrays import real, reals
from cdpr.native.bind import bind
from cdpr.tension.status import Status


def distribute_once(
    operation: str,
    matrix: ArrayLike,
    wrench: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    **options: ArrayLike,
) -> tuple[Array, Status]:
    """Return the answer of an operation of the kernel library to one tension distribution problem.

    Args:
        operation: name of the operation, such as "closed_form".
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m, required wrench of the cables.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable with equal limits is locked at that tension.
        options: further numbers and arrays of the operation.

    Returns:
        Tensions (m,) N, NaN unless the status is OK; and the status.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> distribute_once("closed_form", [[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    numbers = {name: value for name, value in options.items() if isinstance(value, int | float)}
    given = {"matrix": matrix, "wrench": wrench, "tension_min": tension_min, "tension_max": tension_max, **options}
    arrays = reals(**{name: value for name, value in given.items() if name not in numbers})
    tension = np.empty(arrays["tension_min"].shape)
    status = Status(bind(operation, **arrays, **numbers, tension=tension, status=np.empty(1))())
    if status != Status.OK:
        tension[:] = np.nan
    return tension, status


def accept_tension(
    matrix: ArrayLike,
    wrench: ArrayLike,
    weights: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    answer: ArrayLike,
) -> tuple[Array, Array]:
    """Check an answer to a tension distribution problem like the tension stage, and clip it to the limits.

    The tolerances are those of `cdpr.tension.checks`.

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m, required wrench of the cables.
        weights: (n,), 1 for forces, 1 / characteristic length, 1/m, for moments.
        tension_min: (m,) N.
        tension_max: (m,) N.
        answer: (m,) N, tensions of a solver.

    Returns:
        Tensions (m,) N, NaN unless the answer is accepted. Report (4,): the status, OK, NOT_FOUND, or BAD_INPUT if the
            wrench is not finite; weighted residual, N; margin to the nearest limit, N; number of cables at a limit. The
            last three are NaN if an entry is not finite.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> accept_tension([[1.0, -1.0]], [2.0], [1.0], [1.0, 1.0], [9.0, 9.0], [6.0, 4.0])
        (array([6., 4.]), array([0., 0., 3., 0.]))
    """
    limits = np.stack([real(tension_min, "tension_min"), real(tension_max, "tension_max")])
    arrays = reals(matrix=matrix, wrench=wrench, weights=weights, answer=answer)
    tension, report = np.full(arrays["answer"].shape, np.nan), np.full(4, np.nan)
    bind("accept", **arrays, limits=limits, tension=tension, report=report)()
    return tension, report
