"""Arrays of the current sample, and constraints on the cables, as used by the stage of the loop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array


@dataclass(frozen=True, eq=False)
class Present:
    """Current sample of a robot with m cables; results are written into these arrays."""

    W: Array  # (6, m), wrench matrix
    wrench: Array  # (6,), N and N m, world axes, about the platform's origin
    tension: Array  # (m,), N
    report: Array  # (4,): status, residual (N), margin (N), number of cables at a limit

    @classmethod
    def of(cls, m: int) -> Self:
        """Return a new object with zeros."""
        return cls(np.zeros((6, m)), np.zeros(6), np.zeros(m), np.zeros(4))

    @property
    def status(self) -> Array:
        """View of the status, (1,)."""
        return self.report[:1]


@dataclass(frozen=True, eq=False)
class Cables:
    """Limits and imposed tensions of m cables, shared by alternating stages."""

    limits: Array  # (2, m), lowest and highest tensions, N, used by the distribution
    held: Array  # (m,), N, imposed tensions, whatever was distributed; NaN for free cables
    true_limits: Array  # (2, m), N, true limits; the same array as `limits` without a nominal model

    @classmethod
    def of(cls, robot: Robot, true: Robot | None = None) -> Self:
        """Return a robot's limits with all cables free; `true` is the true robot if `robot` is a nominal model."""
        limits = np.array([robot.tension_min, robot.tension_max])
        true_limits = limits if true is None else np.array([true.tension_min, true.tension_max])
        return cls(limits, np.full(robot.m, np.nan), true_limits)

    def copy(self) -> Self:
        """Return a copy of the current values."""
        return type(self)(self.limits.copy(), self.held.copy(), self.true_limits.copy())

    def put(self, other: Self) -> None:
        """Copy the values of another object."""
        self.limits[:], self.held[:], self.true_limits[:] = other.limits, other.held, other.true_limits
