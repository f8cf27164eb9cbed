"""Tensions within the limits with the smallest wrench error, for feasible and infeasible wrenches."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.box_least_squares import nearest_wrench_tension
from cdpr.tension.status import Status


class BestEffort(CompiledSolver):
    """min |D (W t - wrench)| with t_min <= t <= t_max, and least 2-norm among several optima.

    D is the weighting of the tension stage. The solver works for any n, m and rank, thus for underactuated robots and
    failed cables. It first solves the problem of `qp`. If the wrench is feasible, it returns the tensions and the
    status of `qp`. If it is not, a lower limit of -inf is UNSUPPORTED.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        weights = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[robot.rows]
        super().__init__(robot, options, "best_effort", parameters={"weights": weights}, follows=False)


def best_effort_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike, weights: ArrayLike
) -> tuple[Array, Status]:
    """Compute the tensions of least 2-norm that balance the wrench, or else those with the smallest wrench error.

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N, finite.
        tension_max: (m,) N.
        weights: (n,), weight of each component of the wrench error.

    Returns:
        Tensions (m,) N, NaN for UNSUPPORTED and BAD_INPUT. The status: OK, INFEASIBLE where the wrench is not reached,
        NOT_FOUND, UNSUPPORTED where a lower limit is -inf, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> best_effort_tension([[1.0, -1.0]], [12.0], [1.0, 1.0], [9.0, 9.0], [1.0])
        (array([9., 1.]), <Status.INFEASIBLE: 1>)
    """
    return nearest_wrench_tension(matrix, wrench, tension_min, tension_max, weights, "best_effort")
