"""Minimum 2-norm within the limits by Clarabel, an interior-point method (Goulart and Chen 2024)."""

from __future__ import annotations

from typing import Any

import clarabel
import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csc_matrix, identity

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr_solvers.library import LOOSER, LibrarySolver

# Tolerance of the residuals as a multiple of the tolerance of the gap.
FEASIBILITY = 10.0

SETTINGS = {
    "verbose": False,
    "max_threads": 1,
    # Regularisation of the step equations. The default of 1e-8 is as large as the difference of nearly parallel rows.
    "static_regularization_constant": 1e-12,
}

# Largest step, as a share of the way to the boundary. With the default of 0.99, the iteration may cycle.
SHORTER_STEPS = 0.9


class Clarabel(LibrarySolver):
    """min |x|^2 subject to [-N ; N] x + s = [-low ; high], s not negative.

    The tensions never reach a limit exactly: they are about 1e-6 N from the optimum. Each call uses a new solver,
    because the scaling of a reused solver would be that of its first problem. If it does not converge, as in 1 of 1600
    adversarial problems, a second call has a larger tolerance and shorter steps.
    """

    wider = 1e-9  # an interior-point method needs a set with an interior

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        self._attempts = [_settings(options, options.tolerance), _settings(options, LOOSER * options.tolerance)]
        self._attempts[1].max_step_fraction = SHORTER_STEPS
        self._cones = [clarabel.NonnegativeConeT(2 * robot.m)]

        # Hessian and constraint matrix for each redundancy; each call changes the values of the matrix.
        self._matrices: dict[int, tuple[csc_matrix, csc_matrix]] = {}

    def _call_library(self, N: Array, low: Array, high: Array) -> ArrayLike | None:
        m, r = N.shape
        if r not in self._matrices:
            rows = np.tile(np.arange(2 * m), r)
            matrix = csc_matrix((np.ones(2 * m * r), rows, 2 * m * np.arange(r + 1)), shape=(2 * m, r))
            self._matrices[r] = identity(r, format="csc"), matrix
        hessian, matrix = self._matrices[r]
        matrix.data.reshape(r, 2 * m)[:] = np.hstack([-N.T, N.T])
        right = np.concatenate([-low, high])
        for settings in self._attempts:
            answer = clarabel.DefaultSolver(hessian, np.zeros(r), matrix, right, self._cones, settings).solve()
            if answer.status == clarabel.SolverStatus.Solved:  # "almost" solved does not count
                x: ArrayLike = answer.x
                return x
            if answer.status == clarabel.SolverStatus.MaxTime:
                break
        return None


def _settings(options: Any, tolerance: float) -> clarabel.DefaultSettings:
    settings = clarabel.DefaultSettings()
    for name, value in SETTINGS.items():
        setattr(settings, name, value)
    settings.tol_gap_abs = settings.tol_gap_rel = tolerance
    settings.tol_feas = FEASIBILITY * tolerance
    settings.max_iter = options.iterations
    if options.time is not None:
        settings.time_limit = options.time
    return settings
