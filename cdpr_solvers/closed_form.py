"""Closed form, the distribution closest to the middle of the limits (thesis, equation 6.28, corrected)."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class ClosedForm(CompiledSolver):
    """t = t_mid + W^+ (wrench - W t_mid), with t_mid the middle of the limits (Pott, Bruckmann and Mikelsons 2009).

    It is computed as W^+ wrench + N N^T t_mid with an orthonormal basis N of the null space. Both are equal, but this
    form detects a wrench outside the range of W. The method has no iteration and no jump, but it ignores the limits. If
    t violates a limit, another distribution may be admissible, so the status is NOT_FOUND. The status is INFEASIBLE if
    t is so far outside that none is admissible, and UNSUPPORTED if an infinite limit has no middle
    (`nearest_to_middle`). (The thesis prints W_m^t for W t_mid, and t for t_mid.)
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "closed_form", follows=False)


def closed_form_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the distribution closest to the middle of the limits: t = t_mid + W^+ (wrench - W t_mid).

    Pott, Bruckmann and Mikelsons (2009); thesis, equation 6.28, corrected.

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, NOT_FOUND if the tensions violate a limit,
        INFEASIBLE if no tensions are admissible, UNSUPPORTED if an infinite limit has no middle, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> closed_form_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    return distribute_once("closed_form", matrix, wrench, tension_min, tension_max)
