"""Minimum 2-norm within the limits by OSQP (Stellato et al. 2020): how a library is wrapped."""

from __future__ import annotations

from typing import Any

import numpy as np
import osqp
from scipy.sparse import csc_matrix, identity

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.tension import Status

# Counted in iterations, never in seconds: the same problems give the same tensions on any machine.
SETTINGS = {
    "verbose": False,
    "eps_abs": 1e-9,
    "eps_rel": 1e-9,
    "polishing": True,  # without it the method stops at its tolerance, some 1e-3 N from the optimum
    "max_iter": 10_000,
    "check_termination": 25,
    "adaptive_rho": 1,  # every so many iterations
    "adaptive_rho_interval": 50,
    "warm_starting": False,  # an answer depends on earlier problems by no more than its tolerance
}

MEANING = {
    osqp.SolverStatus.OSQP_SOLVED: Status.OK,
    osqp.SolverStatus.OSQP_PRIMAL_INFEASIBLE: Status.INFEASIBLE,
}  # whatever else it says, it found nothing


class Osqp(TensionSolver):
    """min |t|^2 subject to W t = wrench, t_min <= t <= t_max, as rows [W ; 1] t between a lower and an upper bound.

    The library is set up once, with every entry of W in the sparsity pattern; a call updates the values. First-order:
    about 1e-6 N from the exact optimum.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        n, m = robot.n, robot.m
        # The values of [W ; 1] as the library wants them, column by column: n entries of W, then the one.
        self._values = np.zeros((m, n + 1))
        self._values[:, n] = 1.0
        self._low, self._high = np.zeros(n + m), np.zeros(n + m)
        self.reset()

    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` (m,)."""
        n = len(wrench)
        self._values[:, :n] = W.T
        self._low[:n] = self._high[:n] = wrench
        self._low[n:], self._high[n:] = t_min, t_max
        # Asked to update to such data the library prints a line, keeps the old problem and solves that one.
        finite = np.isfinite(self._values).all() and np.isfinite(self._low).all() and np.isfinite(self._high).all()
        if not finite or (self._low > self._high).any():
            return Status.BAD_INPUT
        self._problem.update(Ax=self._values.ravel(), l=self._low, u=self._high)
        answer = self._problem.solve(raise_error=False)
        status = MEANING.get(answer.info.status_val, Status.NOT_FOUND)
        if status == Status.OK:
            tension[:] = answer.x
        return status

    def reset(self) -> None:
        """Start the library anew: its step size adapts to the problems that it has seen."""
        m, width = self._values.shape
        n = width - 1
        rows = np.tile(np.arange(width), (m, 1))
        rows[:, n] += np.arange(m)
        columns = width * np.arange(m + 1)
        pattern = csc_matrix((np.ones(m * width), rows.ravel(), columns), shape=(n + m, m))
        zero = np.zeros(n + m)
        self._problem = osqp.OSQP(algebra="builtin")  # of several installed ones the same everywhere
        self._problem.setup(identity(m, format="csc"), np.zeros(m), pattern, zero, zero, **SETTINGS)
