"""The centroid of the admissible tensions, for one or two redundant cables."""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import null_space, polygon
from cdpr.tension.compiled import distribute_once
from cdpr.tension.null_space import reduce
from cdpr.tension.polygon import centre_of_polygon, clip_interval, clip_polygon
from cdpr.tension.status import INFEASIBLE, UNSUPPORTED, Status
from cdpr.tension.verdict import settle, solution


class Centroid(CompiledSolver):
    """The middle of the interval (r = 1) or the centroid of the polygon (r = 2) of the admissible tensions.

    Continuous in pose and wrench wherever the polygon has an area, and at the edge of the feasible set where it shrinks
    to a point (Mikelsons, Bruckmann, Schramm and Hiller 2008; Gouttefarde, Lamaury, Reichert and Bruckmann 2015). A
    segment, which polygons of different shapes can shrink to, gets its middle. With r = 0 the tensions are determined;
    more than two redundant cables are UNSUPPORTED, as are infinite limits. Locked cables are not redundant.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        corners = 2 * polygon.most_vertices(robot.m)
        rows = null_space.form_rows(robot.m) + 1 + max(null_space.work_rows(robot.n), corners)
        super().__init__(robot, options, centroid, rows=rows, width=max(robot.n, robot.m, 2))


@kernel
def centroid(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the centroid; return OK, INFEASIBLE, UNSUPPORTED or BAD_INPUT."""
    m = W.shape[1]
    N, box, x, rest = work[:m], work[m : m + 3], work[m + 3], work[m + 4 :]
    r = reduce(W, wrench, t_min, t_max, box, N, rest)
    if r < 0:
        return -r
    if r > 2:
        return UNSUPPORTED
    for i in range(m):
        if not (t_max[i] - t_min[i] < math.inf):  # the set may be unbounded, and then has no centroid
            return UNSUPPORTED
    x[0] = x[1] = 0.0
    c, low, high = box[0, :m], box[1, :m], box[2, :m]
    if r == 1:
        if clip_interval(N, c, low, high, x) == 0:
            return INFEASIBLE
        x[0] = 0.5 * (x[0] + x[1])
    elif r == 2:
        k = polygon.most_vertices(m)
        vertices = rest[:k]
        count = clip_polygon(N, c, low, high, vertices, rest[k : 2 * k])
        if count == 0:
            return INFEASIBLE
        centre_of_polygon(vertices, count, x)
    solution(N, r, box, x, tension)
    return settle(W, wrench, box, tension)


def centroid_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the centroid of the admissible tensions, for one or two redundant cables.

    Mikelsons, Bruckmann, Schramm and Hiller (2008); Gouttefarde, Lamaury, Reichert and Bruckmann (2015).

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, INFEASIBLE where none are admissible, UNSUPPORTED
        with more redundant cables or infinite limits, NOT_FOUND where they are too large for numbers, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> centroid_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    return distribute_once("centroid", matrix, wrench, tension_min, tension_max)
