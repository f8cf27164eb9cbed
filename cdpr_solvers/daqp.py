"""Minimum 2-norm within the limits by DAQP, a dual active-set method (Arnström, Bemporad and Axehill 2022)."""

from __future__ import annotations

from typing import Any

import daqp
import numpy as np
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr_solvers.library import LibrarySolver

SETTINGS = {
    "eps_prox": 0.0,  # the problem is strictly convex
    "zero_tol": 1e-11**2,  # for squared lengths of rows of N; the default treats rows below 3e-6 as zero
    # For the squared sine of the angle between a row and the active rows. The default treats rows with a sine below
    # 6e-6 as parallel, and the problem as infeasible. The squared sine is a difference of numbers near 1 with a
    # round-off of 1e-15.
    "sing_tol": 1e-14,
}

SOLVED = 1  # other flags: infeasible, cycling, iterations, ...


class Daqp(LibrarySolver):
    """min |x|^2 subject to low <= N x <= high, exact to round-off."""

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        self._settings = {**SETTINGS, "primal_tol": options.tolerance, "iter_limit": options.iterations}
        self._sense = np.zeros(robot.m, dtype=np.intc)

    def _call_library(self, N: Array, low: Array, high: Array) -> ArrayLike | None:
        answer, _, flag, _ = daqp.solve(*self._square[N.shape[1]], N, high, low, self._sense, **self._settings)
        return answer if flag == SOLVED else None
