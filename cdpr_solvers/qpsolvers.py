"""Minimum 2-norm within the limits by any solver that the library qpsolvers finds installed."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import qpsolvers
from numpy.typing import ArrayLike
from scipy.sparse import csc_matrix

from cdpr.errors import PluginError
from cdpr.model import Robot
from cdpr.plugins.registry import describe
from cdpr.tension import Status
from cdpr_solvers.library import LibrarySolver


class Qpsolvers(LibrarySolver):
    """min |t|^2 subject to W t = wrench, t_min <= t <= t_max; as accurate as the chosen solver and its settings.

    The library does not tell why there is no answer: always NOT_FOUND. Raises PluginError where the solver is not
    installed or does not take the settings.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        n, m = robot.n, robot.m
        available = qpsolvers.available_solvers
        if options.name not in available:
            raise PluginError(
                f"solver 'qpsolvers': no solver is named '{options.name}' or it is not installed: name one of "
                f"{', '.join(available) or 'none'}"
            )
        self._make = np.array if options.name in qpsolvers.dense_solvers else csc_matrix
        self._hessian, self._gradient = self._make(np.eye(m)), np.zeros(m)
        # Wrong settings show in any problem, such as sharing nothing among cables that pull along the axes.
        self.W[:], self.high[:m] = np.eye(n, m), 1.0
        try:
            self._answer()
        except Exception as error:
            raise PluginError(f"solver 'qpsolvers' cannot use {options.name}: {describe(error)}") from error

    def _answer(self) -> qpsolvers.Solution:
        m = self.robot.m
        problem = qpsolvers.Problem(
            self._hessian,
            self._gradient,
            A=self._make(self.W),
            b=self.low[m:],
            lb=self.low[:m],
            ub=self.high[:m],
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what it warns of, a status says or the check of the answer finds
            return qpsolvers.solve_problem(problem, self.options.name, **self.options.settings)

    def _ask(self) -> tuple[int, ArrayLike]:
        try:
            answer = self._answer()
        except Exception:  # of many libraries, each with its own; that they work at all was seen when this was made
            return Status.NOT_FOUND, ()
        return (Status.OK, answer.x) if answer.found and answer.x is not None else (Status.NOT_FOUND, ())
