"""The p-norm about the middle of the limits: the higher p, the more the cables nearest to their limits count."""

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

    Gosselin and Grenier, On the Determination of the Force Distribution in Overconstrained Cable-Driven Parallel
    Mechanisms, Meccanica 46 (2011); here relative to the half ranges, so that limits may differ. p is even: p = 2 is
    the closed form if all ranges are equal, and for large p the largest offset becomes as small as it can be.
    The limits are no constraints: beyond them another distribution may be within, NOT_FOUND.

    Newton's method in the null space, for p = 2, 4, 8, ... up to p, each from the answer of the one before, with a
    line search. Its step solves weighted least squares, by an orthogonal factorisation: the weights u_i^(p-2) span too
    many decades for their normal equations. The answer depends continuously on pose and wrench, and smoothly but where
    so many cables are exactly in the middle that the others leave a direction undetermined.
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
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.
        p: The exponent, an even number of at least 2.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, NOT_FOUND where the tensions break a limit,
        INFEASIBLE where none are admissible, UNSUPPORTED where infinite limits have no middle, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match, or p is odd or less than 2.

    Example:
        >>> p_norm_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    if p < 2 or p % 2 != 0:
        raise ValueError(f"p_norm: p: expected an even number of at least 2, got {p}.")
    return distribute_once("p_norm", matrix, wrench, tension_min, tension_max, p=p)
