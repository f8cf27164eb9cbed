"""Minimum 2-norm within the limits by Clarabel, an interior-point method (Goulart and Chen 2024)."""

from __future__ import annotations

from typing import Any

import clarabel
import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csc_matrix, identity

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr_solvers.library import LibrarySolver

# Residuals are to be smaller than this many tolerances, gaps than one.
FEASIBILITY = 10.0


class Clarabel(LibrarySolver):
    """min |x|^2 subject to [-N ; N] x + s = [-low ; high], s not negative.

    Never quite at a limit: about 1e-6 N from the exact optimum. Made anew for each call, for its scaling would
    otherwise be that of the first problem.
    """

    wider = 1e-9  # an interior-point method needs an inside

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        self._settings = clarabel.DefaultSettings()
        self._settings.verbose = False
        self._settings.max_threads = 1
        self._settings.tol_gap_abs = self._settings.tol_gap_rel = options.tolerance
        self._settings.tol_feas = FEASIBILITY * options.tolerance
        self._settings.max_iter = options.iterations
        if options.time is not None:
            self._settings.time_limit = options.time
        self._cones = [clarabel.NonnegativeConeT(2 * robot.m)]

        # For each redundancy the Hessian and a matrix of constraints whose values a call changes.
        self._made: dict[int, tuple[csc_matrix, csc_matrix]] = {}

    def _ask(self, N: Array, low: Array, high: Array) -> ArrayLike | None:
        m, r = N.shape
        if r not in self._made:
            rows = np.tile(np.arange(2 * m), r)
            matrix = csc_matrix((np.ones(2 * m * r), rows, 2 * m * np.arange(r + 1)), shape=(2 * m, r))
            self._made[r] = identity(r, format="csc"), matrix
        hessian, matrix = self._made[r]
        matrix.data.reshape(r, 2 * m)[:] = np.hstack([-N.T, N.T])
        right = np.concatenate([-low, high])
        solver = clarabel.DefaultSolver(hessian, np.zeros(r), matrix, right, self._cones, self._settings)
        answer = solver.solve()
        return answer.x if answer.status == clarabel.SolverStatus.Solved else None  # "almost" is not
