"""The closed form: the distribution closest to the middle of the limits (thesis, equation 6.28, corrected)."""

from __future__ import annotations

from typing import Any

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import null_space
from cdpr.tension.checks import LIMIT_TOLERANCE
from cdpr.tension.null_space import reduce
from cdpr.tension.status import NOT_FOUND, OK


class ClosedForm(CompiledSolver):
    """t = t_mid + W^+ (wrench - W t_mid), with t_mid half way between the limits (Pott, Bruckmann and Mikelsons 2009).

    Computed as W^+ wrench + N N^T t_mid, N an orthonormal basis of the null space: the same, and a wrench outside the
    range of W is told by the wrench. No iteration and no jump, but the limits are not asked: where t lies outside them
    another distribution may still lie inside, so the answer is NOT_FOUND. (The thesis prints W_m^t for W t_mid, and t
    for t_mid.)
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        n, m = robot.n, robot.m
        floats = null_space.form_size(m) + null_space.work_size(n, m)
        super().__init__(robot, options, closed_form, floats=floats)


@kernel
def closed_form(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the distribution; return OK, NOT_FOUND, INFEASIBLE where W cannot reach the wrench at all, or BAD_INPUT."""
    m = W.shape[1]
    N = work[: m * m].reshape(m, m)
    box = work[m * m : m * m + 3 * m].reshape(3, m)
    r = reduce(W, wrench, t_min, t_max, box, N, work[m * m + 3 * m :])
    if r < 0:
        return -r
    for i in range(m):
        tension[i] = box[0, i]
    for k in range(r):
        x = 0.0
        for i in range(m):
            x += N[i, k] * 0.5 * (box[1, i] + box[2, i])
        for i in range(m):
            tension[i] += N[i, k] * x
    status = OK
    for i in range(m):
        if not box[1, i] - LIMIT_TOLERANCE <= tension[i] <= box[2, i] + LIMIT_TOLERANCE:
            status = NOT_FOUND
    return status
