"""The kernel method: one redundant cable, and a null vector that tightens all of them (thesis, 6.33 to 6.35)."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.rank import RANK_TOLERANCE
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import null_space
from cdpr.tension.compiled import distribute_once
from cdpr.tension.null_space import reduce
from cdpr.tension.status import NOT_FOUND, OK, UNSUPPORTED, Status
from cdpr.tension.verdict import settle


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
        rows = null_space.form_rows(robot.m) + null_space.work_rows(robot.n)
        super().__init__(robot, options, kernel_method, rows=rows)


@kernel
def kernel_method(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the distribution; return OK, UNSUPPORTED, INFEASIBLE, NOT_FOUND or BAD_INPUT."""
    m = W.shape[1]
    N, box, rest = work[:m], work[m : m + 3], work[m + 3 :]
    r = reduce(W, wrench, t_min, t_max, box, N, rest)
    if r < 0:
        return -r
    if r != 1:
        return UNSUPPORTED
    sign = 0.0
    for i in range(m):
        if box[1, i] < box[2, i]:
            h = N[i, 0]
            # A cable that h leaves alone has no sign, but for round-off.
            if abs(h) <= RANK_TOLERANCE or h * sign < 0.0:
                return UNSUPPORTED
            sign = h
    factor = 0.0  # lambda, with the sign of h as it stands in N
    for i in range(m):
        lacking = box[1, i] - box[0, i]
        if lacking > factor * N[i, 0]:
            factor = lacking / N[i, 0]
    for i in range(m):
        tension[i] = box[0, i] + factor * N[i, 0]
    status = settle(W, wrench, box, tension)
    return NOT_FOUND if status != OK and factor == 0.0 else status


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
