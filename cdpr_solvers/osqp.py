"""Minimum 2-norm within the limits by OSQP, an operator-splitting method (Stellato et al. 2020)."""

from __future__ import annotations

from typing import Any

import numpy as np
import osqp
from numpy.typing import ArrayLike
from scipy.sparse import csc_matrix, identity

from cdpr.model import Robot
from cdpr.tension import Status
from cdpr_solvers.library import LibrarySolver

# Counted in iterations, not in seconds unless that is asked for: equal tensions on any machine.
SETTINGS = {
    "verbose": False,
    "polishing": True,  # without it the method stops at its tolerance, some 1e-3 N from the optimum
    "check_termination": 25,
    "adaptive_rho": 1,  # every so many iterations
    "adaptive_rho_interval": 50,
    "warm_starting": False,  # an answer depends on earlier problems by no more than its tolerance
}

MEANING = {
    osqp.SolverStatus.OSQP_SOLVED: Status.OK,
    osqp.SolverStatus.OSQP_PRIMAL_INFEASIBLE: Status.INFEASIBLE,
}  # whatever else it says, it found nothing


class Osqp(LibrarySolver):
    """min |t|^2 subject to low <= [1 ; W] t <= high; first-order, about 1e-5 N from the exact optimum.

    The library is set up once, with every entry of W in the sparsity pattern; a call updates the values.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        # The values of [1 ; W] as the library wants them, column by column: the one, then n entries of W.
        self._values = np.ones((robot.m, 1 + robot.n))
        self._settings = {
            **SETTINGS,
            "eps_abs": options.tolerance,
            "eps_rel": options.tolerance,
            "max_iter": options.iterations,
            **({} if options.time is None else {"time_limit": options.time}),
        }
        self.reset()

    def _ask(self) -> tuple[int, ArrayLike]:
        self._values[:, 1:] = self.W.T
        self._problem.update(Ax=self._values.ravel(), l=self.low, u=self.high)
        answer = self._problem.solve(raise_error=False)
        return MEANING.get(answer.info.status_val, Status.NOT_FOUND), answer.x

    def reset(self) -> None:
        """Start the library anew: its step size adapts to the problems that it has seen."""
        m, width = self._values.shape
        rows = np.tile(np.arange(m - 1, m - 1 + width), (m, 1))
        rows[:, 0] = np.arange(m)
        pattern = csc_matrix((np.ones(m * width), rows.ravel(), width * np.arange(m + 1)), shape=(m + width - 1, m))
        zero = np.zeros(m + width - 1)
        self._problem = osqp.OSQP(algebra="builtin")  # of several installed ones the same everywhere
        self._problem.setup(identity(m, format="csc"), np.zeros(m), pattern, zero, zero, **self._settings)
