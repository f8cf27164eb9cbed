"""Centroid of the admissible tensions, for one or two redundant cables."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class Centroid(CompiledSolver):
    """Middle of the interval (r = 1) or centroid of the polygon (r = 2) of the admissible tensions.

    The tensions are continuous in pose and wrench if the polygon has an area, and at the edge of the feasible set where
    it shrinks to a point (Mikelsons, Bruckmann, Schramm and Hiller 2008; Gouttefarde, Lamaury, Reichert and Bruckmann
    2015). Polygons of different shapes can shrink to one segment, for which the solver returns its middle. With r = 0,
    the tensions are determined. More than two redundant cables and infinite limits are UNSUPPORTED. Locked cables are
    not redundant.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options, "centroid", follows=False)


def centroid_tension(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike
) -> tuple[Array, Status]:
    """Compute the centroid of the admissible tensions, for one or two redundant cables.

    Mikelsons, Bruckmann, Schramm and Hiller (2008); Gouttefarde, Lamaury, Reichert and Bruckmann (2015).

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, INFEASIBLE if no tensions are admissible,
        UNSUPPORTED for more redundant cables or infinite limits, NOT_FOUND if they exceed the range of numbers, or
        BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> centroid_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    return distribute_once("centroid", matrix, wrench, tension_min, tension_max)
