"""Minimum 2-norm within the limits by any installed solver of the library qpsolvers."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import qpsolvers
from numpy.typing import ArrayLike
from scipy.sparse import csc_matrix

from cdpr.base.errors import PluginError, one_line
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr_solvers.library import LibrarySolver
from cdpr_solvers.options import DaqpOptions


class Qpsolvers(LibrarySolver):
    """min |x|^2 subject to [-N ; N] x <= [-low ; high], as accurate as the chosen solver and its settings.

    It raises PluginError if the solver is not installed or does not accept the settings.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        available = qpsolvers.available_solvers
        if options.name not in available:
            raise PluginError(
                f"solver 'qpsolvers': no solver is named '{options.name}' or it is not installed: name one of "
                f"{', '.join(available) or 'none'}"
            )
        self._settings = {**_defaults(options.name), **options.settings}
        self._make = np.asarray if options.name in qpsolvers.dense_solvers else csc_matrix
        # Constraints for each redundancy, filled by each call.
        self._matrices = {r: (np.zeros((2 * robot.m, r)), np.zeros(2 * robot.m)) for r in range(1, robot.m + 1)}
        # Wrong settings raise an error in any problem, for example with a single x between limits.
        try:
            self._answer(np.ones((robot.m, 1)), np.zeros(robot.m), np.ones(robot.m))
        except Exception as error:
            raise PluginError(f"solver 'qpsolvers' cannot use {options.name}: {one_line(error)}") from error

    def _answer(self, N: Array, low: Array, high: Array) -> qpsolvers.Solution:
        m, r = N.shape
        hessian, gradient = self._square[r]
        G, h = self._matrices[r]
        np.negative(N, out=G[:m])
        np.negative(low, out=h[:m])
        G[m:], h[m:] = N, high
        problem = qpsolvers.Problem(self._make(hessian), gradient, self._make(G), h)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the status or the check of the result covers the warnings
            return qpsolvers.solve_problem(problem, self.options.name, **self._settings)

    def _call_library(self, N: Array, low: Array, high: Array) -> ArrayLike | None:
        try:
            answer = self._answer(N, low, high)
        except Exception:  # many libraries with different errors; the constructor has checked that they work
            return None
        return answer.x if answer.found else None


def _defaults(name: str) -> dict[str, float]:
    """Return the settings that make a solver as exact as the built-in solver of the same name."""
    if name != "daqp":
        return {}
    from cdpr_solvers.daqp import SETTINGS

    return {**SETTINGS, "primal_tol": DaqpOptions().tolerance}
