"""DART with a body under the wrench of cdpr's cables, or on rigid legs."""

from __future__ import annotations

from typing import Any

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr_backends.dart.body import DartBackend


def make(robot: Robot, gravity: Array, physics_step: float, options: Any) -> Backend:
    """Return the backend for the chosen kind of cables."""
    if options.cables == "ups":
        from cdpr_backends.dart.legs import DartUps

        return DartUps(robot, gravity, physics_step, options)
    return DartBackend(robot, gravity, physics_step, options)
