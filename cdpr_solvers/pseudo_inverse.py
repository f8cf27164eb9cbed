"""The pseudo-inverse: minimum 2-norm without limits (thesis, equation 6.26)."""

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


class PseudoInverse(CompiledSolver):
    """t = W^+ wrench. It looks at no limit, tensions may come out negative; but locked cables keep what they have."""

    def __init__(self, robot: Robot, options: Any) -> None:
        rows = null_space.form_rows(robot.m) + null_space.work_rows(robot.n)
        super().__init__(robot, options, pseudo_inverse, rows=rows)


@kernel
def pseudo_inverse(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the distribution; return OK, INFEASIBLE or BAD_INPUT."""
    m = W.shape[1]
    N, box = work[:m], work[m : m + 3]
    r = reduce(W, wrench, t_min, t_max, box, N, work[m + 3 :])
    if r < 0:
        return -r
    for i in range(m):
        tension[i] = box[0, i]
    return OK


def pseudo_inverse_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the distribution of least 2-norm, without limits: t = W^+ wrench.

    Thesis, equation 6.26.

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, INFEASIBLE where no tensions balance the wrench,
        NOT_FOUND where they are too large for numbers, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> pseudo_inverse_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([ 1., -1.]), <Status.OK: 0>)
    """
    return distribute_once("pseudo_inverse", matrix, wrench, tension_min, tension_max)
