"""Minimum 2-norm within the limits by PIQP, a proximal interior-point method (Schwan, Jiang, Kuhn and Jones 2023)."""

from __future__ import annotations

from typing import Any

import piqp
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr_solvers.library import LibrarySolver

SETTINGS = {
    "eps_rel": 0.0,
    "eps_duality_gap_rel": 0.0,
    "num_threads": 1,
}


class Piqp(LibrarySolver):
    """min |x|^2 subject to low <= N x <= high; about 1e-5 N from the exact optimum.

    Made anew for each call, which costs a quarter of the time: its scaling would start from that of the problem before.
    """

    wider = 1e-9  # an interior-point method needs an inside

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        self._settings = {
            **SETTINGS,
            "eps_abs": options.tolerance,
            "eps_duality_gap_abs": options.tolerance,
            "max_iter": options.iterations,
        }

    def _ask(self, N: Array, low: Array, high: Array) -> ArrayLike | None:
        solver = piqp.DenseSolver()
        for name, value in self._settings.items():
            setattr(solver.settings, name, value)
        solver.setup(*self._square[N.shape[1]], G=N, h_l=low, h_u=high)
        return solver.result.x if solver.solve() == piqp.PIQP_SOLVED else None
