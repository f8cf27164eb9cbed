"""Minimum 2-norm within the limits: min |t|^2 subject to W t = wrench, t_min <= t <= t_max."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.tension import Status, active_set, null_space
from cdpr.tension.active_set import nearest
from cdpr.tension.null_space import split

OK, INFEASIBLE, NOT_FOUND = int(Status.OK), int(Status.INFEASIBLE), int(Status.NOT_FOUND)


class MinimumNorm(TensionSolver):
    """Exact for any number of cables and any rank, continuous; a convex quadratic program (Bruckmann et al. 2006).

    With t = t_0 + N x, t_0 the solution of least norm and N an orthonormal basis of the null space,
    |t|^2 = |t_0|^2 + |x|^2: the optimum is the point of least norm in a polytope in m - n dimensions.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        n, m = robot.n, robot.m
        # With W rank-deficient the null space may have up to m dimensions.
        self._work = np.zeros(m * m + 3 * m + null_space.work_size(n, m) + active_set.work_size(m, m))

    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` (m,)."""
        return minimum_norm(W, wrench, t_min, t_max, tension, self._work)


@kernel
def minimum_norm(W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, work: Array) -> int:
    """Write the distribution of least norm; return OK, INFEASIBLE or NOT_FOUND."""
    m = W.shape[1]
    basis = work[: m * m].reshape(m, m)
    o = m * m
    particular = work[o : o + m]
    x = work[o + m : o + 2 * m]
    active = work[o + 2 * m : o + 3 * m]
    rest = work[o + 3 * m :]
    rank = split(W, wrench, particular, basis, rest)
    if rank < 0:
        return INFEASIBLE
    steps = nearest(basis, m - rank, particular, t_min, t_max, x, tension, active, rest)
    if steps >= 0:
        return OK
    return INFEASIBLE if steps == active_set.INFEASIBLE else NOT_FOUND
