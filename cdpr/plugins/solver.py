"""The interface of a tension solver."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

from cdpr.model import Robot
from cdpr.model.robot import Array


class TensionSolver(ABC):
    """Distributes a wrench among the cables: find t with W t = wrench and t_min <= t <= t_max.

    A solver never falls back by itself: what to do about an infeasible wrench is decided by the tension stage, which
    also checks every answer.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        self.robot = robot
        self.options = options

    @abstractmethod
    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` and return a `cdpr.tension.Status`.

        W is (n, m), wrench (n,), the others (m,); all C-contiguous float64, the inputs not to be changed. n are the
        robot's degrees of freedom. What `tension` holds when the status is not OK is ignored.
        """

    def reset(self) -> None:  # noqa: B027 - an optional hook
        """Forget what was kept from earlier calls."""
