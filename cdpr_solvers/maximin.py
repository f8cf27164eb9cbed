"""The distribution farthest from the limits: of largest slack, or the centre of the largest ball."""

from __future__ import annotations

import math
from typing import Any

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import null_space, safest
from cdpr.tension.active_set import VERTEX_TOLERANCE
from cdpr.tension.null_space import reduce
from cdpr.tension.safest import safest_point
from cdpr.tension.status import INFEASIBLE, NOT_FOUND, OK


class Maximin(CompiledSolver):
    """max s with W t = wrench and t_min + s d <= t <= t_max - s d; of several optima that of least 2-norm.

    `slack`: d_i = 1, the optimally safe distribution (Borgstrom et al. 2009). `ball`: d_i the length of row i of N, the
    Chebyshev centre of the feasible tensions. Linear programs, exact, any number of cables and any rank. The optimum is
    often a whole face, as at symmetric poses, and then jumps where the face comes or goes.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        n, m = robot.n, robot.m
        super().__init__(
            robot,
            options,
            maximin,
            parameters=[float(options.norm == "ball")],
            floats=null_space.form_size(m) + m + max(null_space.work_size(n, m), safest.work_size(m, m)),
        )


@kernel
def maximin(W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array) -> int:
    """Write the distribution farthest from the limits; return OK, INFEASIBLE, NOT_FOUND or BAD_INPUT."""
    m = W.shape[1]
    o = m * m
    N = work[:o].reshape(m, m)
    box = work[o : o + 3 * m].reshape(3, m)
    x = work[o + 3 * m : o + 4 * m]
    rest = work[o + 4 * m :]
    r = reduce(W, wrench, t_min, t_max, box, N, rest)
    if r < 0:
        return -r
    margin = safest_point(parameters[0] != 0.0, N, r, box[0], box[1], box[2], x, rest)
    if math.isnan(margin):
        return NOT_FOUND
    largest = 0.0
    for i in range(m):
        t = box[0, i]
        for k in range(r):
            t += N[i, k] * x[k]
        largest = max(largest, abs(t))
        tension[i] = min(max(t, box[1, i]), box[2, i])
    return OK if margin >= -VERTEX_TOLERANCE * largest else INFEASIBLE
