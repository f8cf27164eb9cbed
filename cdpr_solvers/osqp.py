"""Minimum 2-norm within the limits by OSQP, an operator-splitting method (Stellato et al. 2020)."""

from __future__ import annotations

from typing import Any

import numpy as np
import osqp
from numpy.typing import ArrayLike
from scipy.sparse import csc_matrix, identity

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr_solvers.library import LibrarySolver

# Limits in iterations, and in seconds only if requested, so that tensions are equal on any machine.
SETTINGS = {
    "verbose": False,
    "polishing": True,  # without it, the method stops at its tolerance, about 1e-3 N from the optimum
    "check_termination": 25,
    "adaptive_rho": 1,  # by number of iterations
    "adaptive_rho_interval": 50,
    "warm_starting": False,  # earlier problems change the tensions by at most the tolerance
}


class Osqp(LibrarySolver):
    """min |x|^2 subject to low <= N x <= high, a first-order method, about 1e-5 N from the exact optimum.

    The library is set up once for each redundancy, with all entries of N in the sparsity pattern. Each call updates the
    values.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        self._settings = {
            **SETTINGS,
            "eps_abs": options.tolerance,
            "eps_rel": options.tolerance,
            "max_iter": options.iterations,
            **({} if options.time is None else {"time_limit": options.time}),
        }
        self.reset()

    def _call_library(self, N: Array, low: Array, high: Array) -> ArrayLike | None:
        r = N.shape[1]
        problem = self._problems.get(r)
        if problem is None:
            problem = self._problems[r] = self._make(r)
        values, one = N.T.ravel(), [1.0]
        problem.update(Ax=np.concatenate([values, one]), l=np.concatenate([low, one]), u=np.concatenate([high, one]))
        answer = problem.solve(raise_error=False)
        return answer.x[:r] if answer.info.status_val == osqp.SolverStatus.OSQP_SOLVED else None

    def _make(self, r: int) -> osqp.OSQP:
        """Set up min |x|^2 + y^2 with y = 1. Without an active limit, polishing would otherwise print a message."""
        m = self.robot.m
        rows = np.append(np.tile(np.arange(m), r), m)
        pattern = csc_matrix((np.ones(m * r + 1), rows, np.append(m * np.arange(r + 1), m * r + 1)), (m + 1, r + 1))
        problem = osqp.OSQP(algebra="builtin")  # same algebra on all machines
        zero = np.zeros(m + 1)
        problem.setup(identity(r + 1, format="csc"), np.zeros(r + 1), pattern, zero, zero, **self._settings)
        return problem

    def reset(self) -> None:
        """Reset the library, whose step size adapts to earlier problems."""
        self._problems: dict[int, osqp.OSQP] = {}
