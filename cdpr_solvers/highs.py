"""Minimum 1-norm within the limits by HiGHS, a simplex method (Huangfu and Hall 2018; thesis, equation 6.24)."""

from __future__ import annotations

from typing import Any

import highspy
import numpy as np
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.tension import Status
from cdpr_solvers.library import LibrarySolver

# The number of threads is left alone: the library has one pool in a process and refuses another size of it.
SETTINGS = {
    "solver": "simplex",
    "parallel": "off",
    "presolve": "off",  # there is nothing to find in so small a program
}

MEANING = {highspy.HighsModelStatus.kOptimal: Status.OK, highspy.HighsModelStatus.kInfeasible: Status.INFEASIBLE}


class Highs(LibrarySolver):
    """min sum of t subject to W t = wrench, t_min <= t <= t_max: a vertex, exact to round-off.

    The optimum jumps from vertex to vertex along a path, and need not be the only one. The model is made once and its
    values are changed, but passed whole: that forgets the last basis, so that equal problems have equal answers, and
    is no slower than entry by entry.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        n, m = robot.n, robot.m
        self._solver = highspy.Highs()
        self._solver.silent()
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
        self._model.num_col_, self._model.num_row_ = m, n
        self._model.col_cost_ = np.ones(m)
        self._model.a_matrix_.format_ = highspy.MatrixFormat.kColwise
        self._model.a_matrix_.start_ = n * np.arange(m + 1)
        self._model.a_matrix_.index_ = np.tile(np.arange(n), m)

    def _ask(self) -> tuple[int, ArrayLike]:
        m = self.robot.m
        model = self._model
        model.a_matrix_.value_ = self.W.T.ravel()
        model.col_lower_, model.col_upper_ = self.low[:m], self.high[:m]
        model.row_lower_ = model.row_upper_ = self.low[m:]
        if self._solver.passModel(model) == highspy.HighsStatus.kError:
            return Status.NOT_FOUND, ()
        self._solver.run()
        status = MEANING.get(self._solver.getModelStatus(), Status.NOT_FOUND)
        return status, self._solver.getSolution().col_value
