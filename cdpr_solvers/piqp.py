"""Minimum 2-norm within the limits by PIQP, a proximal interior-point method (Schwan, Jiang, Kuhn and Jones 2023)."""

from __future__ import annotations

from typing import Any

import piqp
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr_solvers.library import LOOSER, LibrarySolver

SETTINGS = {
    "eps_rel": 0.0,
    "eps_duality_gap_rel": 0.0,
    "num_threads": 1,
}

# Least regularisation of the step equations. The default of 1e-13 disturbs rows as short as 1e-6.
LESS_REGULAR = 1e-16


class Piqp(LibrarySolver):
    """min |x|^2 subject to low <= N x <= high, about 1e-5 N from the exact optimum.

    Each call uses a new solver, which takes a quarter of the time, because the scaling of a reused solver would start
    from that of the previous problem. If it does not converge, as in 1 of 700 adversarial problems, a second call has a
    larger tolerance.
    """

    wider = 1e-9  # an interior-point method needs a set with an interior

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        self._attempts = [
            {
                **SETTINGS,
                "eps_abs": tolerance,
                "eps_duality_gap_abs": tolerance,
                "max_iter": options.iterations,
            }
            for tolerance in (options.tolerance, LOOSER * options.tolerance)
        ]
        self._attempts[1]["reg_finetune_lower_limit"] = LESS_REGULAR

    def _call_library(self, N: Array, low: Array, high: Array) -> ArrayLike | None:
        for settings in self._attempts:
            solver = piqp.DenseSolver()
            for name, value in settings.items():
                setattr(solver.settings, name, value)
            solver.setup(*self._square[N.shape[1]], G=N, h_l=low, h_u=high)
            if solver.solve() == piqp.PIQP_SOLVED:
                x: ArrayLike = solver.result.x
                return x
        return None
