"""The pseudo-inverse: minimum 2-norm without limits (thesis, equation 6.26)."""

from __future__ import annotations

from typing import Any

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import null_space
from cdpr.tension.null_space import reduce
from cdpr.tension.status import OK


class PseudoInverse(CompiledSolver):
    """t = W^+ wrench. It looks at no limit, tensions may come out negative; but locked cables keep what they have."""

    def __init__(self, robot: Robot, options: Any) -> None:
        n, m = robot.n, robot.m
        floats = null_space.form_size(m) + null_space.work_size(n, m)
        super().__init__(robot, options, pseudo_inverse, floats=floats)


@kernel
def pseudo_inverse(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the distribution; return OK, INFEASIBLE or BAD_INPUT."""
    m = W.shape[1]
    N = work[: m * m].reshape(m, m)
    box = work[m * m : m * m + 3 * m].reshape(3, m)
    r = reduce(W, wrench, t_min, t_max, box, N, work[m * m + 3 * m :])
    if r < 0:
        return -r
    for i in range(m):
        tension[i] = box[0, i]
    return OK
