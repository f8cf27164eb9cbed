"""Minimum 2-norm within the limits by PIQP, a proximal interior-point method (Schwan, Jiang, Kuhn and Jones 2023)."""

from __future__ import annotations

from typing import Any

import numpy as np
import piqp
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.tension import Status
from cdpr_solvers.library import LibrarySolver

SETTINGS = {
    "eps_rel": 0.0,
    "eps_duality_gap_rel": 0.0,
    "num_threads": 1,
}

MEANING = {piqp.PIQP_SOLVED: Status.OK, piqp.PIQP_PRIMAL_INFEASIBLE: Status.INFEASIBLE}


class Piqp(LibrarySolver):
    """min |t|^2 subject to W t = wrench, t_min <= t <= t_max; about 1e-5 N from the exact optimum.

    Made anew for each call, which costs a quarter of the time: its scaling would start from that of the problem before.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        self._settings = {
            **SETTINGS,
            "eps_abs": options.tolerance,
            "eps_duality_gap_abs": options.tolerance,
            "max_iter": options.iterations,
        }
        self._hessian, self._gradient = np.eye(robot.m), np.zeros(robot.m)

    def _ask(self) -> tuple[int, ArrayLike]:
        m = self.robot.m
        solver = piqp.DenseSolver()
        for name, value in self._settings.items():
            setattr(solver.settings, name, value)
        low, high = self.low, self.high
        solver.setup(self._hessian, self._gradient, self.W, low[m:], x_l=low[:m], x_u=high[:m])
        return MEANING.get(solver.solve(), Status.NOT_FOUND), solver.result.x
