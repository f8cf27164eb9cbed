"""The kernel method: one redundant cable, and a null vector that tightens all of them (thesis, 6.33 to 6.35)."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class KernelMethod(CompiledSolver):
    """t = t_0 + lambda h, lambda = max (t_min,i - t_0,i) / h_i over the cables with t_0,i < t_min,i, or 0 without any.

    t_0 = W^+ wrench, and h > 0 the null vector of W. For r = m - n = 1 only, and where h has one sign: all cables
    tighten together; suspended robots have no such h. Everything else is UNSUPPORTED. Locked cables do not count.

    lambda is the least that brings all cables to their lower limits, so that where an upper limit is then broken
    nothing is feasible: the method is exact, with the lowest tensions there are. (Limits below zero may leave
    lambda = 0 and a cable above its upper limit, which a negative lambda might cure: NOT_FOUND.) The thesis prints
    |t_p| < 0 as the condition and zero for t_min; it needs its factor 2 for t > 0: with 1 the worst cable has no
    tension at all.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "kernel_method", follows=False)


def kernel_method_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the lowest admissible tensions of a robot with one redundant cable whose null vector has one sign.

    Thesis, equations 6.33 to 6.35, corrected.

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, UNSUPPORTED for other robots, INFEASIBLE where
        none are admissible, NOT_FOUND where limits below zero leave that open, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> kernel_method_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([3., 1.]), <Status.OK: 0>)
    """
    return distribute_once("kernel_method", matrix, wrench, tension_min, tension_max)
