"""Minimum infinity norm within the limits: the largest tension as small as can be, a linear program."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class MinimumLargest(CompiledSolver):
    """min max |t_i| with W t = wrench, t_min <= t <= t_max; of several optima that of least 2-norm.

    Exact for any number of cables and any rank. Gouttefarde et al. (2015) take it from the vertices of the polygon that
    two redundant cables leave; here it is the least s with t = c + N x, -s <= t <= s, a linear program in (x, s). The
    largest tension is continuous, the others jump where it comes to rest on other cables.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "minimum_largest", follows=False)


def minimum_largest_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the admissible distribution whose largest tension is least; of several, that of least 2-norm.

    Gouttefarde, Lamaury, Reichert and Bruckmann (2015).

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, INFEASIBLE where none are admissible, NOT_FOUND
        where the method gave up, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> minimum_largest_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([3., 1.]), <Status.OK: 0>)
    """
    return distribute_once("minimum_largest", matrix, wrench, tension_min, tension_max)
