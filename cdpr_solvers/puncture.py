"""Puncture method, from the pseudo-inverse towards the closed form until all cables are within their limits."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class Puncture(CompiledSolver):
    """t = t_0 + s (t_c - t_0) with the smallest s in [0, 1] within the limits: low tensions in closed form.

    t_0 = W^+ wrench, and t_c is the closed form, the distribution nearest to the middle of the limits. See Müller,
    Reichert and Bruckmann, Analysis of a Real-Time Capable Cable Force Computation Method (2015). Implementations
    (CASPR) test only the lower limits on the way and give up if t_c violates a limit. Here, both limits of every cable
    count, and any point of the segment is accepted. If none is within the limits, another distribution may be
    admissible: NOT_FOUND.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "puncture", follows=False)


def puncture_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the first distribution within the limits on the way from the least norm to the closed form.

    Müller, Reichert and Bruckmann (2015).

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, NOT_FOUND if no point of the segment is
        admissible, INFEASIBLE if no tensions are admissible, UNSUPPORTED if an infinite limit has no middle, or
        BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> puncture_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([3., 1.]), <Status.OK: 0>)
    """
    return distribute_once("puncture", matrix, wrench, tension_min, tension_max)
