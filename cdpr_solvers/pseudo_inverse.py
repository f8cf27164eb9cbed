"""The pseudo-inverse: minimum 2-norm without limits (thesis, equation 6.26)."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.tension import Status, null_space
from cdpr.tension.null_space import split


class PseudoInverse(TensionSolver):
    """t = W^+ wrench. It looks at no limit: tensions may come out negative."""

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        n, m = robot.n, robot.m
        self._basis = np.zeros((m, m))
        self._work = np.zeros(null_space.work_size(n, m))

    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` (m,)."""
        rank = split(W, wrench, tension, self._basis, self._work)
        return Status.OK if rank >= 0 else Status.INFEASIBLE
