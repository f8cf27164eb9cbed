"""What all solvers share that ask a library: the problem as libraries take it best, and no belief in what they say."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.jit import kernel, small
from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.tension import active_set, null_space
from cdpr.tension.active_set import nearest
from cdpr.tension.null_space import reduce
from cdpr.tension.status import BAD_INPUT, NOT_FOUND, OK
from cdpr.tension.verdict import VERTEX_TOLERANCE, solution, verdict

# An answer of a library may break the limits by this share of the largest one: by more than the tolerances that are
# asked of libraries, by less than anyone could measure.
BELIEVED = 2.0 * VERTEX_TOLERANCE

# A limit so many times farther off than any optimum is cut off there: far enough that no method comes near it.
BEYOND = 16.0

# An interior-point method that round-off keeps from its tolerance is asked again for this many times that.
LOOSER = 100.0


class LibrarySolver(TensionSolver):
    """A convex program over low <= N x <= high, solved by a library: its optimum, our verdict on feasibility.

    Libraries check no input, stumble over dependent equations and have tolerances of their own, absolute ones. So they
    are asked in the null space, t = c + N x: no equations are left, wrenches out of the range of W are known before,
    locked cables do not count, and tensions are in units of the largest limit.

    Whether there are admissible tensions is decided first, by `cdpr.tension.active_set.nearest`, and not by a library:
    INFEASIBLE is that kernel's word. What the library then answers is moved to the nearest admissible tensions, which
    that kernel has found already where they are those of least norm; where the library has no answer or one that breaks
    the limits by more than round-off, the status is NOT_FOUND.

    A child gets N (m, r), C-contiguous, and low, high (m,) in `_ask`: r > 0, and rows of cables that x does not change
    are zero, between limits of -1 and 1. The arrays are the solver's own.
    """

    # The library may break the limits by this share of the largest one: round-off of N x in which it could find a set
    # empty that is as thin as that.
    wider = 1e-11

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        m = robot.m
        self._work = np.zeros((_rows(robot.n, m), max(robot.n, m)))
        self._basis, self._limits = np.zeros(m * m), np.zeros((2, m))
        self._asked = [(self._basis[: m * r].reshape(m, r), *self._limits) for r in range(m + 1)]  # by redundancy
        # For each redundancy the Hessian and the gradient of |x|^2 / 2, for those whose objective that is.
        self._square = [(np.eye(r), np.zeros(r)) for r in range(m + 1)]

    @abstractmethod
    def _ask(self, N: Array, low: Array, high: Array) -> ArrayLike | None:
        """Ask the library for the optimal x (r,); None where it has none."""

    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` (m,)."""
        m = self._limits.shape[1]
        if len(tension) != m or W.shape[1] != m:
            return BAD_INPUT
        W = np.ascontiguousarray(W)  # the kernels are compiled for no other order
        r = pose(W, wrench, t_min, t_max, self.wider, self._basis, self._limits, tension, self._work)
        if r <= 0:  # nothing to ask: no tensions are admissible, or one distribution alone
            return -r
        x = self._ask(*self._asked[r])
        if x is None:
            return NOT_FOUND
        return judge(r, np.asarray(x, dtype=float), W, wrench, tension, self._work)


@small
@kernel
def _rows(n: int, m: int) -> int:
    """Rows of work space: for the form, three vectors over cables, and the larger need of the two kernels."""
    return null_space.form_rows(m) + 3 + max(null_space.work_rows(n), active_set.work_rows(m))


@kernel
def pose(
    W: Array,
    wrench: Array,
    t_min: Array,
    t_max: Array,
    wider: float,
    basis: Array,
    limits: Array,
    tension: Array,
    work: Array,
) -> int:
    """Write low <= N x <= high for a library, N (m, r) line by line into `basis`; return r, or minus a status.

    `limits` (2, m) are low and high, `wider` by this share of the largest one, and `tension` (m,) receives the
    admissible tensions of least norm. `work` keeps the form, and the unit of x in N, a power of two, for `judge`.
    """
    m = tension.shape[0]
    if t_min.shape[0] < m or t_max.shape[0] < m:
        return -BAD_INPUT
    largest, lowest = 0.0, 0.0  # of the limits, and of the lower ones
    for i in range(m):
        if not (math.isfinite(t_min[i]) and math.isfinite(t_max[i])):
            return -BAD_INPUT
        if t_min[i] < t_max[i]:  # a locked cable is none of the library's business
            largest = max(largest, abs(t_min[i]), abs(t_max[i]))
            lowest = max(lowest, abs(t_min[i]))
    N, box, x, active, rest = work[:m], work[m : m + 3], work[m + 3], work[m + 4], work[m + 6 :]
    r = reduce(W, wrench, t_min, t_max, box, N, rest)
    if r < 0:
        return r
    steps = nearest(N, r, box, x, tension, active, rest)
    status = verdict(W, wrench, N, r, box, x, tension) if steps >= 0 else -steps
    if status != OK:
        return -status
    # No optimum, of the norm or the sum, has a tension beyond `reach`: of limits farther off, as good as none, the
    # library would take its unit, and have lost the tensions.
    square, spare = 0.0, 0.0
    for i in range(m):
        if t_min[i] < t_max[i]:
            square += tension[i] ** 2
            spare += tension[i] - t_min[i]
    reach = BEYOND * max(math.sqrt(square), spare + lowest)
    if reach == 0.0:
        return 0  # no tensions at all: nothing is less
    largest = min(largest, reach)
    unit = work[m + 5, 0] = _power_of_two(largest)
    for i in range(m):
        moves = False
        for k in range(r):
            basis[i * r + k] = N[i, k]
            moves = moves or N[i, k] != 0.0
        limits[0, i], limits[1, i] = -1.0, 1.0
        if moves:
            limits[0, i] = (t_min[i] - box[0, i]) / unit - wider
            limits[1, i] = (min(t_max[i], largest) - box[0, i]) / unit + wider
    return r


@kernel
def _power_of_two(x: float) -> float:
    """The largest power of two that is not above x > 0, division by which rounds nothing; 1 for 0."""
    return math.ldexp(0.5, math.frexp(x)[1]) if x > 0.0 else 1.0


@kernel
def judge(r: int, x: Array, W: Array, wrench: Array, tension: Array, work: Array) -> int:
    """Write the admissible tensions nearest to c + N x; return OK, or NOT_FOUND where x breaks the limits.

    `tension` (m,) comes with admissible ones, those of least norm, which are the answer where x is the same but for
    round-off.
    """
    m = tension.shape[0]
    N, box, least, active, point, rest = (
        work[:m],
        work[m : m + 3],
        work[m + 3],
        work[m + 4],
        work[m + 5, :m],
        work[m + 6 :],
    )
    unit = point[0]
    for k in range(r):
        least[k] = unit * x[k]
    solution(N, r, box, least, point)
    same = True
    for i in range(m):
        same = same and abs(point[i] - tension[i]) <= BELIEVED * unit
    if same:
        return OK
    for i in range(m):
        moves = False
        for k in range(r):
            moves = moves or N[i, k] != 0.0
        if moves and not max(box[1, i] - point[i], point[i] - box[2, i]) <= BELIEVED * unit:  # NaN, too
            return NOT_FOUND
    for i in range(m):
        box[0, i] = point[i]
    if nearest(N, r, box, least, point, active, rest) >= 0 and verdict(W, wrench, N, r, box, least, point) == OK:
        for i in range(m):
            tension[i] = point[i]
        return OK
    return NOT_FOUND
