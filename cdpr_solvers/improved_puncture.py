"""The improved puncture method: from the pseudo-inverse towards the improved closed form until within the limits."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class ImprovedPuncture(CompiledSolver):
    """t = t_0 + s (t_c - t_0) with the smallest s in [0, 1] that is within the limits: low tensions, few misses.

    As `puncture`, but t_c is the improved closed form, within the limits wherever it has an answer: the two methods of
    Müller, Reichert and Bruckmann (2015) and Pott (2013) in one, as CASPR combines them (`id_cf_ipm`). Where the
    improved closed form has none the answer is its status. It jumps where that does.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "improved_puncture", follows=False)


def improved_puncture_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the first distribution within the limits on the way from the least norm to the improved closed form.

    Müller, Reichert and Bruckmann (2015); Pott (2013).

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, NOT_FOUND where no answer was found, INFEASIBLE
        where none are admissible, UNSUPPORTED where infinite limits have no middle, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> improved_puncture_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([3., 1.]), <Status.OK: 0>)
    """
    return distribute_once("improved_puncture", matrix, wrench, tension_min, tension_max)
