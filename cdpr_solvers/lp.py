"""Minimum 1-norm within the limits, a linear program (thesis, equation 6.24)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status
from cdpr_solvers.options import per_cable


class MinimumSum(CompiledSolver):
    """min sum w_i t_i, exact for any number of cables and any rank; least 2-norm among several optima.

    The optimum is a vertex in general. It jumps to another vertex where the cost becomes parallel to an edge.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(
            robot,
            options,
            "minimum_sum",
            parameters={"weights": np.array(per_cable(robot, "weights", options.weights))},
            follows=False,
        )


def minimum_sum_tension(
    matrix: ArrayLike,
    wrench: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    weights: ArrayLike | None = None,
) -> tuple[Array, Status]:
    """Compute the admissible distribution of least weighted sum; of several, that of least 2-norm.

    Thesis, equation 6.24.

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.
        weights: (m,) cost of each tension, by default all 1.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, INFEASIBLE if no tensions are admissible,
        UNSUPPORTED if infinite limits leave no minimum, NOT_FOUND if the method did not converge, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> minimum_sum_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([3., 1.]), <Status.OK: 0>)
    """
    costs = np.ones(np.shape(tension_min)) if weights is None else weights
    return distribute_once("minimum_sum", matrix, wrench, tension_min, tension_max, weights=costs)
