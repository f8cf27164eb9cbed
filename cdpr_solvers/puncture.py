"""The puncture method: from the pseudo-inverse towards the closed form until all cables are within their limits."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class Puncture(CompiledSolver):
    """t = t_0 + s (t_c - t_0) with the smallest s in [0, 1] that is within the limits: low tensions, in closed form.

    t_0 = W^+ wrench, and t_c the closed form, nearest to the middle of the limits. Müller, Reichert and Bruckmann,
    Analysis of a Real-Time Capable Cable Force Computation Method (2015). Implementations (CASPR) ask only the lower
    limits on the way and give up where t_c itself is beyond a limit; here both limits of every cable count, and any
    point of the segment will do. Where none is within the limits another distribution may be: NOT_FOUND.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "puncture", follows=False)


def puncture_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the first distribution within the limits on the way from the least norm to the closed form.

    Müller, Reichert and Bruckmann (2015).

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, NOT_FOUND where no point of that segment is
        admissible, INFEASIBLE where none are admissible, UNSUPPORTED where infinite limits have no middle, or
        BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> puncture_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([3., 1.]), <Status.OK: 0>)
    """
    return distribute_once("puncture", matrix, wrench, tension_min, tension_max)
