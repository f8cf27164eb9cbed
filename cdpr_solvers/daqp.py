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
    "eps_prox": 0.0,  # the problem is strictly convex as it is
    "zero_tol": 1e-11**2,  # of squared lengths of rows of N: by default it takes rows below 3e-6 for zero
    # Of the squared sine between a row and those at their limits; by default it takes rows less than 6e-6 apart for one
    # and the problem for infeasible. The sine's square is a difference of numbers near 1, whose round-off is 1e-15.
    "sing_tol": 1e-14,
}

SOLVED = 1  # the others: infeasible, cycling, iterations, ...


class Daqp(LibrarySolver):
    """min |x|^2 subject to low <= N x <= high; exact to round-off."""

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        self._settings = {**SETTINGS, "primal_tol": options.tolerance, "iter_limit": options.iterations}
        self._sense = np.zeros(robot.m, dtype=np.intc)

    def _ask(self, N: Array, low: Array, high: Array) -> ArrayLike | None:
        answer, _, flag, _ = daqp.solve(*self._square[N.shape[1]], N, high, low, self._sense, **self._settings)
        return answer if flag == SOLVED else None
