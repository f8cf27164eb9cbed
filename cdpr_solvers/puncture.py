"""The puncture method: from the pseudo-inverse towards the closed form until all cables are within their limits."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import null_space
from cdpr.tension.compiled import distribute_once
from cdpr.tension.null_space import reduce
from cdpr.tension.status import OK, Status
from cdpr.tension.verdict import VERTEX_TOLERANCE
from cdpr_solvers.projection import admitted, nearest_to_middle


class Puncture(CompiledSolver):
    """t = t_0 + s (t_c - t_0) with the smallest s in [0, 1] that is within the limits: low tensions, in closed form.

    t_0 = W^+ wrench, and t_c the closed form, nearest to the middle of the limits. Müller, Reichert and Bruckmann,
    Analysis of a Real-Time Capable Cable Force Computation Method (2015). Implementations (CASPR) ask only the lower
    limits on the way and give up where t_c itself is beyond a limit; here both limits of every cable count, and any
    point of the segment will do. Where none is within the limits another distribution may be: NOT_FOUND.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        rows = null_space.form_rows(robot.m) + 2 + null_space.work_rows(robot.n)
        super().__init__(robot, options, puncture, rows=rows)


@kernel
def puncture(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the distribution; return OK, NOT_FOUND, INFEASIBLE where that is certain, UNSUPPORTED or BAD_INPUT."""
    m = W.shape[1]
    N, box, spare, end, rest = work[:m], work[m : m + 3], work[m + 3, :m], work[m + 4, :m], work[m + 5 :]
    r = reduce(W, wrench, t_min, t_max, box, N, rest)
    if r < 0:
        return -r
    status = nearest_to_middle(N, r, box, spare, end)
    if status != OK:
        return status
    return least_step(W, wrench, r, box, end, tension)


@kernel
def least_step(W: Array, wrench: Array, r: int, box: Array, end: Array, tension: Array) -> int:
    """Write the first point on the way from the least norm to `end` (m,) within the limits; return as `admitted`."""
    m = tension.shape[0]
    start = box[0]
    s, scale = 0.0, 0.0
    for i in range(m):
        scale = max(scale, abs(end[i]))
    for i in range(m):
        lacking = max(box[1, i] - start[i], 0.0) + min(box[2, i] - start[i], 0.0)
        # A step that the verdict does not ask for would be round-off over round-off.
        if abs(lacking) > VERTEX_TOLERANCE * scale and lacking * (end[i] - start[i]) > 0.0:
            s = max(s, lacking / (end[i] - start[i]))
    s = min(s, 1.0)
    for i in range(m):
        tension[i] = start[i] + s * (end[i] - start[i])
    return admitted(W, wrench, r, box, tension)


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
