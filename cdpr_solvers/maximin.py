"""Distribution farthest from the limits: largest slack, or centre of the largest ball."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class Maximin(CompiledSolver):
    """max s with W t = wrench and t_min + s d <= t <= t_max - s d, and least 2-norm among several optima.

    `slack`: d_i = 1, the optimally safe distribution (Borgstrom et al. 2009). `ball`: d_i is the length of row i of N,
    the Chebyshev centre of the feasible tensions. Both are linear programs, exact for any number of cables and any
    rank. The optimum is often a whole face, for example at symmetric poses. The tensions jump where the face appears or
    disappears.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "maximin", parameters={"ball": int(options.norm == "ball")}, follows=False)


def maximin_tension(
    matrix: ArrayLike,
    wrench: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    *,
    ball: bool = False,
) -> tuple[Array, Status]:
    """Compute the distribution farthest from the limits; of several, that of least 2-norm.

    Borgstrom et al. (2009).

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.
        ball: if True, return the centre of the largest ball in the null space within the limits (Chebyshev), instead of
            the tensions whose smallest distance from the limits is largest.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, INFEASIBLE if no tensions are admissible,
        UNSUPPORTED if infinite limits allow any distance, NOT_FOUND if the method did not converge, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> maximin_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    return distribute_once("maximin", matrix, wrench, tension_min, tension_max, ball=int(ball))
