"""The closed form: the distribution closest to the middle of the limits (thesis, equation 6.28, corrected)."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.tension import Status, null_space
from cdpr.tension.checks import LIMIT_TOLERANCE
from cdpr.tension.null_space import split

OK, INFEASIBLE, NOT_FOUND = int(Status.OK), int(Status.INFEASIBLE), int(Status.NOT_FOUND)


class ClosedForm(TensionSolver):
    """t = t_mid + W^+ (wrench - W t_mid), with t_mid half way between the limits (Pott, Bruckmann and Mikelsons 2009).

    Computed as W^+ wrench + N N^T t_mid, N an orthonormal basis of the null space: the same, and a wrench outside the
    range of W is told by the wrench. No iteration and no jump, but the limits are not asked: where t lies outside them
    another distribution may still lie inside, so the answer is NOT_FOUND. (The thesis prints W_m^t for W t_mid, and t
    for t_mid.)
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        n, m = robot.n, robot.m
        self._work = np.zeros(m * m + null_space.work_size(n, m))

    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` (m,)."""
        return closed_form(W, wrench, t_min, t_max, tension, self._work)


@kernel
def closed_form(W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, work: Array) -> int:
    """Write the distribution; return OK, INFEASIBLE where W cannot reach the wrench at all, or NOT_FOUND."""
    m = W.shape[1]
    basis = work[: m * m].reshape(m, m)
    rank = split(W, wrench, tension, basis, work[m * m :])
    if rank < 0:
        return INFEASIBLE
    for k in range(m - rank):
        x = 0.0
        for i in range(m):
            x += basis[i, k] * 0.5 * (t_min[i] + t_max[i])
        for i in range(m):
            tension[i] += basis[i, k] * x
    status = OK
    for i in range(m):
        inside = tension[i] >= t_min[i] - LIMIT_TOLERANCE and tension[i] <= t_max[i] + LIMIT_TOLERANCE
        if not inside:  # also where it is NaN
            status = NOT_FOUND
    return status
