"""Pseudo-inverse, the minimum 2-norm without limits (thesis, equation 6.26)."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class PseudoInverse(CompiledSolver):
    """t = W^+ wrench. It ignores the limits, so tensions may be negative; only locked cables keep their tensions."""

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "pseudo_inverse", follows=False)


def pseudo_inverse_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the distribution of least 2-norm, without limits: t = W^+ wrench.

    Thesis, equation 6.26.

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, INFEASIBLE if no tensions balance the wrench,
        NOT_FOUND if they exceed the range of numbers, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> pseudo_inverse_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([ 1., -1.]), <Status.OK: 0>)
    """
    return distribute_once("pseudo_inverse", matrix, wrench, tension_min, tension_max)
