"""The tensions within the limits that come nearest to the wrench, whether they balance it or not."""

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
    """min |D (W t - wrench)| with t_min <= t <= t_max, of several optima that of least 2-norm; D as in the stage.

    Any n, m and rank: for underactuated robots and cables that failed. First asked is what `qp` asks: where the wrench
    can be balanced the answer is that of `qp`, and so is the status. A lower limit of -inf is then UNSUPPORTED where it
    cannot.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        weights = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[robot.rows]
        super().__init__(robot, options, "best_effort", parameters={"weights": weights}, follows=False)


def best_effort_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike, weights: ArrayLike
) -> tuple[Array, Status]:
    """Compute the tensions of least 2-norm that balance the wrench, or else those that come nearest to it.

    Args:
        matrix: (n, m), rows of the wrench matrix W, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.
        weights: (n,), 1 for forces, 1 / characteristic length, 1/m, for moments: of |D (W t - wrench)|.

    Returns:
        Tensions (m,) N, NaN unless the status is OK or INFEASIBLE. The status: OK where they balance the wrench,
        INFEASIBLE where none do, UNSUPPORTED where none do and a lower limit is infinite, NOT_FOUND or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> best_effort_tension([[1.0, -1.0]], [20.0], [1.0, 1.0], [9.0, 9.0], [1.0])
        (array([9., 1.]), <Status.INFEASIBLE: 1>)
    """
    return nearest_wrench_tension(matrix, wrench, tension_min, tension_max, weights, "best_effort")
