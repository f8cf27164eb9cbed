"""Analytic centre of the admissible tensions, a smooth distribution away from all limits."""

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


class AnalyticCentre(CompiledSolver):
    """min -sum w_i [log(t_i - t_min,i) + log(t_max,i - t_i)] with W t = wrench, by Newton's method in the null space.

    The solver works for any number of cables and any rank. Inside the feasible set, the tensions are a smooth function
    (C-infinity) of the pose and the wrench. See Boyd and Vandenberghe, Convex Optimization (2004), sections 8.5.3 and
    9.6, for a barrier with weights.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(
            robot,
            options,
            "analytic_centre",
            parameters={"weights": np.array(per_cable(robot, "weights", options.weights))},
            follows=False,
        )


def analytic_centre_tension(
    matrix: ArrayLike,
    wrench: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    weights: ArrayLike | None = None,
) -> tuple[Array, Status]:
    """Compute the analytic centre of the admissible tensions.

    Boyd and Vandenberghe, Convex Optimization (2004), sections 8.5.3 and 9.6.

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.
        weights: (m,) positive weights of the distances from the limits, by default all 1.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, INFEASIBLE if no tensions are admissible,
        UNSUPPORTED if infinite limits leave no centre, NOT_FOUND if the method did not converge, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> analytic_centre_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    shares = np.ones(np.shape(tension_min)) if weights is None else weights
    return distribute_once("analytic_centre", matrix, wrench, tension_min, tension_max, weights=shares)
