"""Minimum 2-norm within the limits by DAQP, a dual active-set method (Arnström, Bemporad and Axehill 2022)."""

from __future__ import annotations

from typing import Any

import daqp
import numpy as np
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.tension import Status
from cdpr_solvers.library import LibrarySolver

SETTINGS = {
    "eps_prox": 0.0,  # the problem is strictly convex as it is
}

MEANING = {1: Status.OK, -1: Status.INFEASIBLE}  # the others: cycling, iterations, dependent equations, ...

EQUATION = 5  # what the library calls a row with one value


class Daqp(LibrarySolver):
    """min |t|^2 subject to W t = wrench, t_min <= t <= t_max; exact to round-off.

    Whether dependent rows of W contradict each other the library cannot tell: NOT_FOUND then.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        n, m = robot.n, robot.m
        self._settings = {**SETTINGS, "primal_tol": options.tolerance, "iter_limit": options.iterations}
        self._hessian, self._gradient = np.eye(m), np.zeros(m)
        self._sense = np.zeros(m + n, dtype=np.intc)
        self._sense[m:] = EQUATION

    def _ask(self) -> tuple[int, ArrayLike]:
        answer, _, flag, _ = daqp.solve(
            self._hessian, self._gradient, self.W, self.high, self.low, self._sense, **self._settings
        )
        return MEANING.get(flag, Status.NOT_FOUND), answer
