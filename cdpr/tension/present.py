"""What the stage of the loop works on: the arrays of the present sample, and what is asked of the cables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array


@dataclass(frozen=True, eq=False)
class Present:
    """The present sample of a robot with m cables, live: who writes, writes into these arrays."""

    W: Array  # (6, m), wrench matrix
    wrench: Array  # (6,), N and N m, world axes, about the platform's origin
    tension: Array  # (m,), N
    report: Array  # (4,): status, residual (N), margin (N), number of cables at a limit

    @classmethod
    def of(cls, m: int) -> Self:
        """Return one of its own, all zeros."""
        return cls(np.zeros((6, m)), np.zeros(6), np.zeros(m), np.zeros(4))

    @property
    def status(self) -> Array:
        """A view of the status, (1,)."""
        return self.report[:1]


@dataclass(frozen=True, eq=False)
class Cables:
    """What is allowed and imposed, live, for m cables; stages that take turns share it."""

    limits: Array  # (2, m), lowest and highest tensions, N, as the distribution knows them
    held: Array  # (m,), N, tensions that cables have whatever was distributed; NaN for those that are free
    true_limits: Array  # (2, m), N, those of the robot that is moved; `limits` itself where these are known

    @classmethod
    def of(cls, robot: Robot, true: Robot | None = None) -> Self:
        """Return a robot's limits, all cables free; `true` is the robot that is moved, where that is another."""
        limits = np.array([robot.tension_min, robot.tension_max])
        true_limits = limits if true is None else np.array([true.tension_min, true.tension_max])
        return cls(limits, np.full(robot.m, np.nan), true_limits)

    def copy(self) -> Self:
        """Return how they are now."""
        return type(self)(self.limits.copy(), self.held.copy(), self.true_limits.copy())

    def put(self, other: Self) -> None:
        """Make them as others are."""
        self.limits[:], self.held[:], self.true_limits[:] = other.limits, other.held, other.true_limits
