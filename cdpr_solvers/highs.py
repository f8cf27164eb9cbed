"""Minimum 1-norm within the limits by HiGHS, a simplex method (Huangfu and Hall 2018; thesis, equation 6.24)."""

from __future__ import annotations

from typing import Any

import highspy
import numpy as np
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr_solvers.library import LibrarySolver

# Costs below this share of their terms are round-off. With such a cost, the library ends without a status.
ROUNDING = 1e-11

# No number of threads: the library has one pool per process and rejects another size of it.
SETTINGS = {
    "solver": "simplex",
    "parallel": "off",
    "presolve": "off",  # a program this small gains nothing
}


class _SilentHighs(highspy.Highs):  # type: ignore[misc]  # highspy declares no types
    """HiGHS without output, also during construction, in which it registers callbacks and prints a banner."""

    def enableCallbacks(self) -> None:  # noqa: N802 - overrides a method of highspy
        self.silent()
        super().enableCallbacks()


class Highs(LibrarySolver):
    """min sum of N x subject to low <= N x <= high, a vertex, exact to round-off.

    The optimum jumps between vertices along a path and may not be unique. Each call passes the complete model. This
    discards the last basis, so that equal problems give equal tensions, and is as fast as a change of the entries.
    """

    wider = 0.0  # it keeps the limits to its own tolerance, which a sum over the cables reveals

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        self._solver = _SilentHighs()
        self._solver.silent()  # again, for versions that register no callbacks
        settings = {
            **SETTINGS,
            "primal_feasibility_tolerance": options.tolerance,
            "dual_feasibility_tolerance": options.tolerance,
            "simplex_iteration_limit": options.iterations,
            **({} if options.time is None else {"time_limit": options.time}),
        }
        for name, value in settings.items():
            self._solver.setOptionValue(name, value)
        self._model = highspy.HighsLp()
        self._model.num_row_ = robot.m
        self._model.a_matrix_.format_ = highspy.MatrixFormat.kRowwise

    def _call_library(self, N: Array, low: Array, high: Array) -> ArrayLike | None:
        m, r = N.shape
        model = self._model
        if model.num_col_ != r:
            model.num_col_ = r
            model.col_lower_, model.col_upper_ = np.full(r, -highspy.kHighsInf), np.full(r, highspy.kHighsInf)
            model.a_matrix_.start_ = r * np.arange(m + 1)
            model.a_matrix_.index_ = np.tile(np.arange(r), m)
        cost = sum(N, start=np.zeros(r))  # row by row
        model.col_cost_ = np.where(np.abs(cost) <= ROUNDING * sum(np.abs(N), start=np.zeros(r)), 0.0, cost)
        model.a_matrix_.value_ = N.ravel()
        model.row_lower_, model.row_upper_ = low, high
        if self._solver.passModel(model) == highspy.HighsStatus.kError:
            return None
        self._solver.run()
        solved = self._solver.getModelStatus() == highspy.HighsModelStatus.kOptimal
        return self._solver.getSolution().col_value if solved else None
