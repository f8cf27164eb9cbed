"""The centroid of the admissible tensions, for one or two redundant cables."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class Centroid(CompiledSolver):
    """The middle of the interval (r = 1) or the centroid of the polygon (r = 2) of the admissible tensions.

    Continuous in pose and wrench wherever the polygon has an area, and at the edge of the feasible set where it shrinks
    to a point (Mikelsons, Bruckmann, Schramm and Hiller 2008; Gouttefarde, Lamaury, Reichert and Bruckmann 2015). A
    segment, which polygons of different shapes can shrink to, gets its middle. With r = 0 the tensions are determined;
    more than two redundant cables are UNSUPPORTED, as are infinite limits. Locked cables are not redundant.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "centroid", follows=False)


def centroid_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the centroid of the admissible tensions, for one or two redundant cables.

    Mikelsons, Bruckmann, Schramm and Hiller (2008); Gouttefarde, Lamaury, Reichert and Bruckmann (2015).

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, INFEASIBLE where none are admissible, UNSUPPORTED
        with more redundant cables or infinite limits, NOT_FOUND where they are too large for numbers, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> centroid_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    return distribute_once("centroid", matrix, wrench, tension_min, tension_max)
