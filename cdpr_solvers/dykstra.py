"""Dykstra's alternating projections between the solutions of W t = wrench and the limits."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class Dykstra(CompiledSolver):
    """Iteration towards the distribution nearest to the middle of the limits, NOT_FOUND after `iterations` steps.

    The method is that of Hassan and Khajepour, Analysis of Bounded Cable Tensions in Cable-Actuated Parallel
    Manipulators (2011), with the algorithm of Boyle and Dykstra (1986). It starts from t_mid. Each step projects on { W
    t = wrench }, adds the correction that the last projection on the limits removed, and projects the sum on the
    limits. The affine set needs no correction. (Without it, or with a start that is never moved, the iteration has
    another limit or none.)

    The last projection is on { W t = wrench }, so the tensions balance the wrench to round-off. They then violate the
    limits by at most `tolerance`, a share of the largest limit, and are moved onto them. This is also the test of
    convergence. The difference t_mid - t is the sum of a part in the range of W^T and of the correction, which is
    normal to the limits at the projected point. So t is the optimum if both points are equal.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(
            robot,
            options,
            "dykstra",
            parameters={"iterations": options.iterations, "tolerance": options.tolerance},
            follows=False,
        )


def dykstra_tension(
    matrix: ArrayLike,
    wrench: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    iterations: int = 500,
    tolerance: float = 1e-12,
) -> tuple[Array, Status]:
    """Compute the admissible distribution nearest to the middle of the limits, by alternating projections.

    Boyle and Dykstra (1986); Hassan and Khajepour (2011).

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.
        iterations: largest number of pairs of projections.
        tolerance: largest violation of a limit before tensions are moved onto it, as a share of the largest limit.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, NOT_FOUND if the method did not converge,
        INFEASIBLE if no tensions are admissible, UNSUPPORTED if an infinite limit has no middle, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> dykstra_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    return distribute_once(
        "dykstra", matrix, wrench, tension_min, tension_max, iterations=iterations, tolerance=tolerance
    )
