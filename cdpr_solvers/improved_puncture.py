"""Improved puncture method, from the pseudo-inverse towards the improved closed form until within the limits."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class ImprovedPuncture(CompiledSolver):
    """t = t_0 + s (t_c - t_0) with the smallest s in [0, 1] within the limits: low tensions, few missed wrenches.

    It is `puncture` with the improved closed form as t_c, which is within the limits whenever it finds a distribution.
    CASPR combines the methods of Müller, Reichert and Bruckmann (2015) and Pott (2013) in this way (`id_cf_ipm`). If
    the improved closed form finds no distribution, its status is returned. The tensions jump where those of the
    improved closed form do.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "improved_puncture", follows=False)


def improved_puncture_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the first distribution within the limits on the way from the least norm to the improved closed form.

    Müller, Reichert and Bruckmann (2015); Pott (2013).

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, NOT_FOUND if no distribution was found,
        INFEASIBLE if no tensions are admissible, UNSUPPORTED if an infinite limit has no middle, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> improved_puncture_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([3., 1.]), <Status.OK: 0>)
    """
    return distribute_once("improved_puncture", matrix, wrench, tension_min, tension_max)
