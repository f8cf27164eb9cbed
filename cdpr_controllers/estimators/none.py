"""Measured pose and twist as the state. A loop does this without an estimator; the class exists for other uses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Estimator, SensorModel, SnapshotOfArrays
from cdpr.sensing import Pose, Twist


class Measured(SnapshotOfArrays, Estimator):
    """State from the first sensors of the pose and of the twist."""

    arrays: tuple[Array, ...] = ()

    def __init__(
        self, robot: Robot, gravity: Array, control_step: float, sensors: Sequence[SensorModel], options: Any
    ) -> None:
        super().__init__(robot, gravity, control_step, sensors, options)
        self._pose, self._twist = self.first(Pose), self.first(Twist)

    def estimate(self, time: float, out: Array) -> None:
        """Write the measured state (13,)."""
        out[:7], out[7:] = self._pose.measured, self._twist.measured
