"""The improved puncture method: from the pseudo-inverse towards the improved closed form until within the limits."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import null_space
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import OK, Status
from cdpr_solvers.improved_closed_form import improved_closed_form
from cdpr_solvers.puncture import least_step


class ImprovedPuncture(CompiledSolver):
    """t = t_0 + s (t_c - t_0) with the smallest s in [0, 1] that is within the limits: low tensions, few misses.

    As `puncture`, but t_c is the improved closed form, within the limits wherever it has an answer: the two methods of
    Müller, Reichert and Bruckmann (2015) and Pott (2013) in one, as CASPR combines them (`id_cf_ipm`). Where the
    improved closed form has none the answer is its status. It jumps where that does.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        rows = null_space.form_rows(robot.m) + 2 + null_space.work_rows(robot.n)
        super().__init__(robot, options, improved_puncture, parameters=[0.0], rows=rows)


@kernel
def improved_puncture(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the distribution; return OK, NOT_FOUND, INFEASIBLE where that is certain, or BAD_INPUT."""
    m = W.shape[1]
    box, end = work[1 + m : m + 4], work[0, :m]
    status = improved_closed_form(W, wrench, t_min, t_max, end, parameters, work[1:])
    if status != OK:
        return status
    return least_step(W, wrench, 1, box, end, tension)


def improved_puncture_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the first distribution within the limits on the way from the least norm to the improved closed form.

    Müller, Reichert and Bruckmann (2015); Pott (2013).

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, NOT_FOUND where no answer was found, INFEASIBLE
        where none are admissible, UNSUPPORTED where infinite limits have no middle, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> improved_puncture_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([3., 1.]), <Status.OK: 0>)
    """
    return distribute_once("improved_puncture", matrix, wrench, tension_min, tension_max)
