"""The closed form: the distribution closest to the middle of the limits (thesis, equation 6.28, corrected)."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class ClosedForm(CompiledSolver):
    """t = t_mid + W^+ (wrench - W t_mid), with t_mid half way between the limits (Pott, Bruckmann and Mikelsons 2009).

    Computed as W^+ wrench + N N^T t_mid, N an orthonormal basis of the null space: the same, and a wrench outside the
    range of W is told by the wrench. No iteration and no jump, but the limits are not asked: where t lies outside them
    another distribution may still lie inside, so the answer is NOT_FOUND; it is INFEASIBLE where t is so far out that
    none can, and UNSUPPORTED where infinite limits have no middle (`nearest_to_middle`). (The thesis prints W_m^t for
    W t_mid, and t for t_mid.)
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "closed_form", follows=False)


def closed_form_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the distribution closest to the middle of the limits: t = t_mid + W^+ (wrench - W t_mid).

    Pott, Bruckmann and Mikelsons (2009); thesis, equation 6.28, corrected.

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, NOT_FOUND where the tensions break a limit,
        INFEASIBLE where none are admissible, UNSUPPORTED where infinite limits have no middle, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> closed_form_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    return distribute_once("closed_form", matrix, wrench, tension_min, tension_max)
