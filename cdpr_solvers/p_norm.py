"""Least p-norm around the middle of the limits; a higher p gives more weight to the cables nearest to their limits."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class PNorm(CompiledSolver):
    """min sum u_i^p with W t = wrench, where u_i is the offset of t_i from the middle of its limits in half ranges.

    See Gosselin and Grenier, On the Determination of the Force Distribution in Overconstrained Cable-Driven Parallel
    Mechanisms, Meccanica 46 (2011). Here, the offsets are relative to the half ranges, so that limits may differ. p is
    even. p = 2 is the closed form if all ranges are equal. For large p, the largest offset approaches its least value.
    The limits are not constraints: if the tensions violate them, another distribution may be admissible (NOT_FOUND).

    Newton's method in the null space with a line search solves p = 2, 4, 8, ... up to p, each from the result of the
    previous one. Each step is a weighted least-squares problem, solved by an orthogonal factorisation. The weights
    u_i^(p-2) span too many decades for normal equations. The tensions are continuous in pose and wrench. They are
    smooth, unless too many cables are exactly at the middle and the others leave a direction undetermined.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "p_norm", parameters={"p": options.p}, follows=False)


def p_norm_tension(
    matrix: ArrayLike,
    wrench: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    p: int = 4,
) -> tuple[Array, Status]:
    """Compute the distribution of least p-norm about the middle of the limits, in half ranges.

    Gosselin and Grenier, Meccanica 46 (2011).

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.
        p: exponent, an even number of at least 2.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, NOT_FOUND if the tensions violate a limit,
        INFEASIBLE if no tensions are admissible, UNSUPPORTED if an infinite limit has no middle, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match, or p is odd or less than 2.

    Example:
        >>> p_norm_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    if p < 2 or p % 2 != 0:
        raise ValueError(f"p_norm: p: expected an even number of at least 2, got {p}.")
    return distribute_once("p_norm", matrix, wrench, tension_min, tension_max, p=p)
