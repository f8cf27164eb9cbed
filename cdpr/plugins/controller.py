"""The interface of a controller."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

from cdpr.model import Robot
from cdpr.model.robot import Array


class Controller(ABC):
    """Decides the wrench that the cables must exert on the platform.

    `gravity` is (3,), m/s^2, world; `control_step` is the time between two calls, s.
    """

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        self.robot = robot
        self.gravity = gravity
        self.control_step = control_step
        self.options = options

    @abstractmethod
    def control(self, time: float, state: Array, desired: Array, wrench: Array) -> None:
        """Write into `wrench` (6,) the force and the moment about the platform's origin, world axes.

        `state` is (13,) and `desired` (19,), laid out as `cdpr.model` says; neither may be changed.
        """

    def reset(self) -> None:  # noqa: B027 - an optional hook
        """Forget what was kept from earlier calls."""
