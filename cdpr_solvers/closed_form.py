"""The closed form: the distribution closest to the middle of the limits (thesis, equation 6.28, corrected)."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import null_space
from cdpr.tension.compiled import distribute_once
from cdpr.tension.null_space import reduce
from cdpr.tension.status import OK, Status
from cdpr_solvers.projection import admitted, nearest_to_middle


class ClosedForm(CompiledSolver):
    """t = t_mid + W^+ (wrench - W t_mid), with t_mid half way between the limits (Pott, Bruckmann and Mikelsons 2009).

    Computed as W^+ wrench + N N^T t_mid, N an orthonormal basis of the null space: the same, and a wrench outside the
    range of W is told by the wrench. No iteration and no jump, but the limits are not asked: where t lies outside them
    another distribution may still lie inside, so the answer is NOT_FOUND; it is INFEASIBLE where t is so far out that
    none can, and UNSUPPORTED where infinite limits have no middle (`nearest_to_middle`). (The thesis prints W_m^t for
    W t_mid, and t for t_mid.)
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        rows = null_space.form_rows(robot.m) + 1 + null_space.work_rows(robot.n)
        super().__init__(robot, options, closed_form, rows=rows)


@kernel
def closed_form(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the distribution; return OK, NOT_FOUND, INFEASIBLE where that is certain, UNSUPPORTED or BAD_INPUT."""
    m = W.shape[1]
    N, box, middle = work[:m], work[m : m + 3], work[m + 3, :m]
    r = reduce(W, wrench, t_min, t_max, box, N, work[m + 4 :])
    if r < 0:
        return -r
    status = nearest_to_middle(N, r, box, middle, tension)
    if status != OK:
        return status
    return admitted(W, wrench, r, box, tension)


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
