"""Minimum 2-norm within the limits by Clarabel, an interior-point method (Goulart and Chen 2024)."""

from __future__ import annotations

from typing import Any

import clarabel
import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csc_matrix, identity

from cdpr.model import Robot
from cdpr.tension import Status
from cdpr_solvers.library import LibrarySolver

# Residuals are to be smaller than this many tolerances, gaps than one.
FEASIBILITY = 10.0

MEANING = {
    clarabel.SolverStatus.Solved: Status.OK,
    clarabel.SolverStatus.PrimalInfeasible: Status.INFEASIBLE,
}  # "almost" either is neither


class Clarabel(LibrarySolver):
    """min |t|^2 subject to [W ; -1 ; 1] t + s = [wrench ; -t_min ; t_max], s zero or not negative.

    Never quite at a limit: about 1e-6 N from the exact optimum. Made anew for each call, for its scaling would
    otherwise be that of the first problem.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        n, m = robot.n, robot.m
        self._settings = clarabel.DefaultSettings()
        self._settings.verbose = False
        self._settings.max_threads = 1
        self._settings.tol_gap_abs = self._settings.tol_gap_rel = options.tolerance
        self._settings.tol_feas = FEASIBILITY * options.tolerance
        self._settings.max_iter = options.iterations
        if options.time is not None:
            self._settings.time_limit = options.time
        self._hessian, self._gradient = identity(m, format="csc"), np.zeros(m)
        self._cones = [clarabel.ZeroConeT(n), clarabel.NonnegativeConeT(2 * m)]
        # Column i: n entries of W, then -1 for its lower and 1 for its upper limit.
        rows = np.tile(np.arange(n + 2), (m, 1))
        rows[:, n] = n + np.arange(m)
        rows[:, n + 1] = n + m + np.arange(m)
        values = np.tile([*np.zeros(n), -1.0, 1.0], (m, 1))
        self._matrix = csc_matrix((values.ravel(), rows.ravel(), (n + 2) * np.arange(m + 1)), shape=(n + 2 * m, m))
        self._values = self._matrix.data.reshape(m, n + 2)

    def _ask(self) -> tuple[int, ArrayLike]:
        n, m = self.W.shape
        self._values[:, :n] = self.W.T
        right = np.concatenate([self.low[m:], -self.low[:m], self.high[:m]])
        solver = clarabel.DefaultSolver(self._hessian, self._gradient, self._matrix, right, self._cones, self._settings)
        answer = solver.solve()
        return MEANING.get(answer.status, Status.NOT_FOUND), answer.x
