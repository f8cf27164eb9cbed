"""Kernel method, for one redundant cable and a null vector that tightens all cables (thesis, 6.33 to 6.35)."""

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

    t_0 = W^+ wrench, and h > 0 is the null vector of W. The method works only for r = m - n = 1 and an h of one sign,
    so that all cables tighten together. Suspended robots have no such h. All other cases are UNSUPPORTED. Locked cables
    do not count.

    lambda is the least value that lifts all cables to their lower limits. So if a cable then violates an upper limit,
    no distribution is admissible: the method is exact and gives the lowest tensions. (Limits below zero may lead to
    lambda = 0 and a cable above its upper limit. A negative lambda might then be admissible: NOT_FOUND.) The thesis
    prints |t_p| < 0 as the condition and zero for t_min. It needs its factor 2 for t > 0: with 1, the worst cable has
    no tension.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "kernel_method", follows=False)


def kernel_method_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the lowest admissible tensions of a robot with one redundant cable whose null vector has one sign.

    Thesis, equations 6.33 to 6.35, corrected.

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, UNSUPPORTED for other robots, INFEASIBLE if no
        tensions are admissible, NOT_FOUND if limits below zero leave this open, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> kernel_method_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([3., 1.]), <Status.OK: 0>)
    """
    return distribute_once("kernel_method", matrix, wrench, tension_min, tension_max)
