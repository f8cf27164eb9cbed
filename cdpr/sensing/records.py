"""Rows of a log, from which sensors compute the true values of what they measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cdpr.model import rotations
from cdpr.model.robot import Array


@dataclass(frozen=True, eq=False)
class Records:
    """Recorded states of a run.

    Attributes:
        state: (K, 13), true states.
        gravity: (3,), m/s^2.
        step: control period, s.
        every: control steps from one row to the next.
        ideal: True if cables are ideal, so that their tensions are the commanded ones and drums unwind their lengths.
        solids: (s, w), rows of the obstacles for the kernels, if the sensor `sees_obstacles` and the log has them; else
            None.
        column: function that returns a column (K, w) by its name, or None if the log does not have it.
    """

    state: Array
    gravity: Array
    step: float
    every: int
    ideal: bool
    solids: Array | None
    column: Callable[[str], Array | None]

    @property
    def position(self) -> Array:
        """Positions of the platform's origin (K, 3), m."""
        return self.state[:, :3]

    @property
    def attitude(self) -> Array:
        """Attitudes of the platform (K, 4)."""
        return self.state[:, 3:7]

    @property
    def velocity(self) -> Array:
        """Velocities of the platform's origin (K, 3), m/s."""
        return self.state[:, 7:10]

    @property
    def turn_rate(self) -> Array:
        """Angular velocities (K, 3), rad/s, world axes."""
        return self.state[:, 10:]

    def to_world(self, vectors: Array) -> Array:
        """Return vectors (3,) or (K, 3) in world axes, given in those of the platform."""
        return rotations.rotate(self.attitude, vectors)

    def to_platform(self, vectors: Array) -> Array:
        """Return vectors (3,) or (K, 3) in axes of the platform, given in those of the world."""
        return rotations.rotate(rotations.conjugate(self.attitude), vectors)
