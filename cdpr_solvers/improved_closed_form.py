"""Improved closed form, which fixes cables beyond their limits there one after the other (thesis, 6.30 to 6.32)."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension.compiled import distribute_once
from cdpr.tension.status import Status


class ImprovedClosedForm(CompiledSolver):
    """Closed form that fixes the worst cable at its limit, then the next, until all are within their limits.

    See Pott, An Improved Force Distribution Algorithm for Over-Constrained Cable-Driven Parallel Robots (2013), and
    thesis 6.30 to 6.32, "advanced closed form". With t_i = b, the others solve W' t' = wrench - b W_i by the closed
    form. In the null space, this is a step t += N n (b - t_i) / |n|^2. The vector n is the part of row i of N that is
    orthogonal to the rows of the fixed cables. At most r = m - n cables can be fixed. The others are still tested
    against their limits after that.

    `rule: published` fixes the cable farthest beyond its limit in newtons. `rule: scaled` fixes the cable with the
    largest ratio of this distance to |n|. No cable is released. So the method may miss a feasible wrench (with r = 1
    only under `published`), and its tensions may not be the nearest to the middle. They jump where two cables are
    equally far outside and the order of fixing changes.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(
            robot, options, "improved_closed_form", parameters={"scaled": int(options.rule == "scaled")}, follows=False
        )


def improved_closed_form_tension(
    matrix: ArrayLike,
    wrench: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    *,
    scaled: bool = False,
) -> tuple[Array, Status]:
    """Compute the closed form, with the cables beyond their limits fixed there one after the other.

    Pott (2013); thesis, equations 6.30 to 6.32.

    Args:
        matrix: (n, m) rows of the wrench matrix, with moments about the platform's origin, in world axes.
        wrench: (n,) required wrench of the cables on the platform [N, N m].
        tension_min: (m,) lower limits [N].
        tension_max: (m,) upper limits [N]. A cable with equal limits is locked at that tension.
        scaled: if True, fix the cable with the largest ratio of its violation to its share in the null space first,
            instead of the cable farthest beyond its limit in newtons, as published.

    Returns:
        Tensions (m,) [N], NaN unless the status is OK. The status: OK, NOT_FOUND if no distribution was found,
        INFEASIBLE if no tensions are admissible, UNSUPPORTED if an infinite limit has no middle, or BAD_INPUT.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> improved_closed_form_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [4.0, 9.0])
        (array([4., 2.]), <Status.OK: 0>)
    """
    return distribute_once("improved_closed_form", matrix, wrench, tension_min, tension_max, scaled=int(scaled))
