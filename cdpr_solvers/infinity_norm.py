"""Minimum infinity norm within the limits: the largest tension as small as can be, a linear program."""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import active_set, null_space
from cdpr.tension.active_set import extreme
from cdpr.tension.compiled import distribute_once
from cdpr.tension.null_space import reduce
from cdpr.tension.status import BAD_INPUT, Status
from cdpr.tension.verdict import settle, solution


class MinimumLargest(CompiledSolver):
    """min max |t_i| with W t = wrench, t_min <= t <= t_max; of several optima that of least 2-norm.

    Exact for any number of cables and any rank. Gouttefarde et al. (2015) take it from the vertices of the polygon that
    two redundant cables leave; here it is the least s with t = c + N x, -s <= t <= s, a linear program in (x, s). The
    largest tension is continuous, the others jump where it comes to rest on other cables.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        n, m = robot.n, robot.m
        super().__init__(
            robot,
            options,
            minimum_largest,
            rows=null_space.form_rows(m) + _program_rows(m) + max(null_space.work_rows(n), active_set.work_rows(m + 1)),
            width=max(n, 3 * m),
        )


def _program_rows(m: int) -> int:
    """Rows of work space for the linear program: its N and box, cost, x, point and active limits."""
    return 3 * m + 3 + 4


@kernel
def minimum_largest(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the distribution whose largest tension is least; return OK, INFEASIBLE, NOT_FOUND or BAD_INPUT."""
    m = W.shape[1]
    if work.shape[1] < 3 * m or work.shape[0] < 6 * m + 20:
        return BAD_INPUT  # made for another robot
    N, box, rest = work[:m], work[m : m + 3], work[m + 3 :]
    rows, level = rest[: 3 * m], rest[3 * m : 3 * m + 3]  # the linear program's N and box
    g, y, point, active = rest[3 * m + 3], rest[3 * m + 4], rest[3 * m + 5], rest[3 * m + 6]
    rest = rest[3 * m + 7 :]
    r = reduce(W, wrench, t_min, t_max, box, N, rest)
    if r < 0:
        return -r
    count = 0
    for i in range(m):
        # t within its limits, t <= s, and -t <= s where it may be negative.
        for kind in range(3):
            if (kind == 0 and box[1, i] == box[2, i]) or (kind == 2 and box[1, i] >= 0.0):
                continue
            for j in range(r):
                rows[count, j] = N[i, j]
            rows[count, r] = 0.0 if kind == 0 else (-1.0 if kind == 1 else 1.0)
            level[0, count] = box[0, i]
            level[1, count] = -math.inf
            level[2, count] = math.inf
            if kind == 0:
                level[1, count], level[2, count] = box[1, i], box[2, i]
            elif kind == 1:
                level[2, count] = 0.0
            else:
                level[1, count] = 0.0
            count += 1
    for j in range(r):
        g[j] = 0.0
    g[r] = 1.0
    steps = extreme(g, rows, r + 1, level, y, point[:count], active[:count], rest)
    if steps < 0:
        return -steps
    solution(N, r, box, y, tension)
    return settle(W, wrench, box, tension)


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
