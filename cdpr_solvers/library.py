"""What all solvers share that ask a library: the problem as libraries take it, and no belief in what they say."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.tension import Status
from cdpr.tension.checks import RESIDUAL_TOLERANCE
from cdpr.tension.null_space import RANK_TOLERANCE
from cdpr.tension.verdict import VERTEX_TOLERANCE

# Scaled, entries of W and tensions are below 2 each.
REACH = 4.0

OK, NOT_FOUND = int(Status.OK), int(Status.NOT_FOUND)


class LibrarySolver(TensionSolver):
    """A convex program over low <= [1 ; W] t <= high, the limits above and the equations below, solved by a library.

    Libraries check no input and have tolerances of their own, absolute ones, so a call
    - refuses what is not finite and limits that contradict each other,
    - scales tensions and rows to numbers below 2, by powers of two, which rounds nothing,
    - refuses a wrench so large that no cables could reach it: some libraries take large numbers for infinity,
    - calls an answer NOT_FOUND that leaves the limits by more than round-off or misses the wrench by more than the
      tension stage allows.

    A child reads `W` (n, m), C-contiguous, and `low`, `high` (m + n,), all its own copies, in `_ask`.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        n, m = robot.n, robot.m
        self.W = np.zeros((n, m))
        self.low, self.high = np.zeros(m + n), np.zeros(m + n)

    @abstractmethod
    def _ask(self) -> tuple[int, ArrayLike]:
        """Ask the library about `W`, `low` and `high`; return a `cdpr.tension.Status` and, where OK, t (m,)."""

    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` (m,)."""
        scale = stack(W, wrench, t_min, t_max, self.W, self.low, self.high)
        if scale <= 0.0:
            return Status.BAD_INPUT if scale == 0.0 else Status.INFEASIBLE
        status, answer = self._ask()
        if status != OK:
            return status
        return take(np.asarray(answer), scale, W, wrench, t_min, t_max, tension)


@kernel
def stack(W: Array, wrench: Array, t_min: Array, t_max: Array, scaled_W: Array, low: Array, high: Array) -> float:
    """Write the scaled problem; return the unit of its tensions, N.

    Returns 0.0 where the input is bad, and -1.0 where some entry of the wrench is beyond all that the largest entry of
    its row and the largest tension could do. A row below RANK_TOLERANCE of the largest is round-off and must stay
    small: it gets the unit of the largest.
    """
    n, m = W.shape
    unit = 1.0
    for i in range(m):
        if not (math.isfinite(t_min[i]) and math.isfinite(t_max[i]) and t_min[i] <= t_max[i]):
            return 0.0
        unit = max(unit, abs(t_min[i]), abs(t_max[i]))
    unit = _power_of_two(unit)
    for i in range(m):
        low[i], high[i] = t_min[i] / unit, t_max[i] / unit
    largest = 0.0
    for j in range(n):
        if not math.isfinite(wrench[j]):
            return 0.0
        for i in range(m):
            if not math.isfinite(W[j, i]):
                return 0.0
            largest = max(largest, abs(W[j, i]))
    for j in range(n):
        size = 0.0
        for i in range(m):
            size = max(size, abs(W[j, i]))
        row_unit = _power_of_two(size if size > RANK_TOLERANCE * largest else largest)
        for i in range(m):
            scaled_W[j, i] = W[j, i] / row_unit
        low[m + j] = high[m + j] = wrench[j] / row_unit / unit
        if abs(low[m + j]) > REACH * m:
            return -1.0
    return unit


@kernel
def _power_of_two(x: float) -> float:
    """The largest power of two that is not above x > 0; 1 for 0."""
    return math.ldexp(0.5, math.frexp(x)[1]) if x > 0.0 else 1.0


@kernel
def take(answer: Array, unit: float, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
    """Write unit * answer into `tension`, moved onto limits that it breaks by round-off.

    Returns OK if it is then within the limits and balances, else NOT_FOUND.
    """
    n, m = W.shape
    status = OK
    for i in range(m):
        found = unit * answer[i]
        tension[i] = min(max(found, t_min[i]), t_max[i])
        if not abs(found - tension[i]) <= 2.0 * unit * VERTEX_TOLERANCE:  # NaN, too; no limit is above 2 units
            status = NOT_FOUND
    load, residual = 1.0, 0.0
    for j in range(n):
        s = -wrench[j]
        for i in range(m):
            s += W[j, i] * tension[i]
        load = max(load, abs(wrench[j]))
        residual = max(residual, abs(s))
    return status if residual <= RESIDUAL_TOLERANCE * load else NOT_FOUND
