"""Base of the solvers that use a library: formulation of the problem, and independent checks of the results."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.arrays import FLOAT, real
from cdpr.native.bind import bind
from cdpr.plugins import TensionSolver
from cdpr.tension.status import BAD_INPUT, NOT_FOUND, OK

# Factor of the tolerance in a second call, for interior-point methods that round-off keeps from the first tolerance.
LOOSER = 100.0

GIVEN = "W", "wrench", "t_min", "t_max"


class LibrarySolver(TensionSolver):
    """Convex program over low <= N x <= high, solved by a library, with feasibility decided by cdpr.

    Libraries do not check their input, have difficulties with dependent equations, and have absolute tolerances. So the
    problem is formulated in the null space, t = c + N x. There are then no equations, wrenches outside the range of W
    are known before, locked cables are excluded, and tensions are in units of the largest limit.

    `library_problem` of the kernel library (`library.hpp`) first decides whether admissible tensions exist. Only it
    leads to INFEASIBLE. The result of the library is then moved to the nearest admissible tensions. These are already
    known if the objective is the least norm. The status is NOT_FOUND if the library returns no result, or one that
    violates the limits by more than round-off.

    A subclass receives N (m, r), C-contiguous, and low, high (m,) in `_call_library`, with r > 0. Rows of cables that
    x does not change are zero, between limits of -1 and 1. The arrays belong to the solver.
    """

    # Share of the largest limit by which the library may violate the limits. A set that is as thin as the round-off of
    # N x could otherwise be empty for the library.
    wider = 1e-11

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        n, m = robot.n, robot.m
        packed, bounds = np.zeros(m * m), np.zeros((2, m))
        self._views = [(packed[: m * r].reshape(m, r), *bounds) for r in range(m + 1)]  # by redundancy
        # Hessian and gradient of |x|^2 / 2 for each redundancy, for solvers with this objective.
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
    def _call_library(self, N: Array, low: Array, high: Array) -> ArrayLike | None:
        """Return the optimal x (r,) of the library, None if it finds none."""

    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` (m,)."""
        given = W, wrench, t_min, t_max
        if tension.shape != self._tension.shape or any(
            array.shape != own.shape for array, own in zip(given, self._given, strict=True)
        ):
            return BAD_INPUT
        for array, own, name in zip(given, self._given, GIVEN, strict=True):
            own[...] = array if type(array) is np.ndarray and array.dtype is FLOAT else real(array, name)
        status = self._pose()
        r = int(self._redundancy[0])
        if status == OK and r > 0:  # otherwise no tensions are admissible, or exactly one distribution
            x = self._call_library(*self._views[r])
            if x is None:
                return NOT_FOUND
            self._x[:r] = x
            status = self._judge()
        tension[:] = self._tension
        return status
