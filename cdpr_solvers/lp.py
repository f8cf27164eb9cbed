"""Minimum 1-norm within the limits: a linear program (thesis, equation 6.24)."""

from __future__ import annotations

from typing import Any

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import active_set, null_space
from cdpr.tension.active_set import extreme
from cdpr.tension.null_space import reduce
from cdpr.tension.status import OK
from cdpr_solvers.options import per_cable


class MinimumSum(CompiledSolver):
    """min sum w_i t_i: exact, any number of cables and any rank; of several optima that of least 2-norm.

    The optimum is a vertex in general, and jumps to another where the cost becomes parallel to an edge.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        n, m = robot.n, robot.m
        super().__init__(
            robot,
            options,
            minimum_sum,
            parameters=per_cable(robot, "weights", options.weights),
            floats=null_space.form_size(m) + 3 * m + max(null_space.work_size(n, m), active_set.work_size(m, m)),
        )


@kernel
def minimum_sum(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the distribution of least weighted sum; return OK, INFEASIBLE, NOT_FOUND or BAD_INPUT."""
    m = W.shape[1]
    o = m * m
    N = work[:o].reshape(m, m)
    box = work[o : o + 3 * m].reshape(3, m)
    o += 3 * m
    x = work[o : o + m]
    active = work[o + m : o + 2 * m]
    g = work[o + 2 * m : o + 3 * m]
    rest = work[o + 3 * m :]
    r = reduce(W, wrench, t_min, t_max, box, N, rest)
    if r < 0:
        return -r
    for k in range(r):
        g[k] = 0.0
        for i in range(m):
            g[k] += N[i, k] * parameters[i]
    steps = extreme(g, N, r, box[0], box[1], box[2], x, tension, active, rest)
    return OK if steps >= 0 else -steps
