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
