"""What all solvers share that ask a library: the problem as libraries take it best, and no belief in what they say."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import TensionSolver
from cdpr.tension.status import BAD_INPUT, NOT_FOUND, OK

# An interior-point method that round-off keeps from its tolerance is asked again for this many times that.
LOOSER = 100.0


class LibrarySolver(TensionSolver):
    """A convex program over low <= N x <= high, solved by a library: its optimum, our verdict on feasibility.

    Libraries check no input, stumble over dependent equations and have tolerances of their own, absolute ones. So they
    are asked in the null space, t = c + N x: no equations are left, wrenches out of the range of W are known before,
    locked cables do not count, and tensions are in units of the largest limit.

    Whether there are admissible tensions is decided first, by `library_problem` of the kernel library (`library.hpp`):
    INFEASIBLE is its word. What the library then answers is moved to the nearest admissible tensions, which
    it has found already where they are those of least norm; where the library has no answer or one that breaks
    the limits by more than round-off, the status is NOT_FOUND.

    A child gets N (m, r), C-contiguous, and low, high (m,) in `_ask`: r > 0, and rows of cables that x does not change
    are zero, between limits of -1 and 1. The arrays are the solver's own.
    """

    # The library may break the limits by this share of the largest one: round-off of N x in which it could find a set
    # empty that is as thin as that.
    wider = 1e-11

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        n, m = robot.n, robot.m
        packed, bounds = np.zeros(m * m), np.zeros((2, m))
        self._asked = [(packed[: m * r].reshape(m, r), *bounds) for r in range(m + 1)]  # by redundancy
        # For each redundancy the Hessian and the gradient of |x|^2 / 2, for those whose objective that is.
        self._square = [(np.eye(r), np.zeros(r)) for r in range(m + 1)]
        self._given = np.zeros((n, m)), np.zeros(n), np.zeros(m), np.zeros(m)
        self._tension, self._x, self._redundancy = np.zeros(m), np.zeros(m), np.zeros(1)
        matrix, wrench, low, high = self._given
        shared = {
            "matrix": matrix,
            "wrench": wrench,
            "tension_min": low,
            "tension_max": high,
            "tension": self._tension,
            "redundancy": self._redundancy,
            "unit": np.zeros(1),
            "basis": np.zeros((m, m)),
            "box": np.zeros((4, m)),
        }
        self._pose = bind("library_problem", **shared, packed=packed, bounds=bounds, wider=self.wider)
        self._judge = bind("library_answer", **shared, x=self._x)

    @abstractmethod
    def _ask(self, N: Array, low: Array, high: Array) -> ArrayLike | None:
        """Ask the library for the optimal x (r,); None where it has none."""

    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` (m,)."""
        given = W, wrench, t_min, t_max
        if tension.shape != self._tension.shape or any(
            array.shape != own.shape for array, own in zip(given, self._given, strict=True)
        ):
            return BAD_INPUT
        for array, own in zip(given, self._given, strict=True):
            own[...] = array
        status = self._pose()
        r = int(self._redundancy[0])
        if status == OK and r > 0:  # else nothing to ask: no tensions are admissible, or one distribution alone
            x = self._ask(*self._asked[r])
            if x is None:
                return NOT_FOUND
            self._x[:r] = x
            status = self._judge()
        tension[:] = self._tension
        return status
