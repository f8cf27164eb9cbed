"""Minimum infinity norm within the limits: the smallest possible largest tension, by a linear program."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class MinimumLargest(CompiledSolver):
    """min max |t_i| with W t = wrench, t_min <= t <= t_max, and least 2-norm among several optima.

    The solver is exact for any number of cables and any rank. Gouttefarde et al. (2015) compute the optimum from the
    vertices of the polygon of two redundant cables. Here it is the least s with t = c + N x, -s <= t <= s, a linear
    program in (x, s). The largest tension is continuous. The others jump where another set of cables has the largest
    tension.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "minimum_largest", follows=False)


def minimum_largest_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the admissible distribution whose largest tension is least; of several, that of least 2-norm.

    Gouttefarde, Lamaury, Reichert and Bruckmann (2015).

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, INFEASIBLE if no tensions are admissible,
        NOT_FOUND if the method did not converge, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> minimum_largest_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([3., 1.]), <Status.OK: 0>)
    """
    return distribute_once("minimum_largest", matrix, wrench, tension_min, tension_max)
