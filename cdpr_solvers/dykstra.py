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
    """Tends to the distribution nearest to the middle of the limits; gives up after so many iterations: NOT_FOUND.

    Hassan and Khajepour, Analysis of Bounded Cable Tensions in Cable-Actuated Parallel Manipulators (2011), by the
    algorithm of Boyle and Dykstra (1986): from t_mid, project on { W t = wrench }, then on the limits what this gave
    plus the correction that the projection on the limits took away last time, and so on. The affine set needs no
    correction. (Without it, or with a start that is never moved, the limit is another or none at all.)

    It ends with a projection on { W t = wrench }, so that answers balance to round-off; they are then within
    `tolerance`, a share of the largest limit, of the limits, and are moved onto them. This is also the test of
    convergence: t_mid - t is then the sum of a part in the range of W^T and of the correction, which is normal to the
    limits at the point projected from, so that where the two points are one it is the optimum.
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
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.
        iterations: Pairs of projections after which the method gives up.
        tolerance: How far beyond its limits a tension may be before it is moved onto them, as a share of the largest
            limit.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, NOT_FOUND where the method gave up, INFEASIBLE
        where none are admissible, UNSUPPORTED where infinite limits have no middle, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> dykstra_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    return distribute_once(
        "dykstra", matrix, wrench, tension_min, tension_max, iterations=iterations, tolerance=tolerance
    )
