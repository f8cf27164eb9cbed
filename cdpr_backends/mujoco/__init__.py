"""MuJoCo with a body under the wrench of cdpr's cables, on MuJoCo's spatial tendons, or on rigid legs."""

from __future__ import annotations

from typing import Any

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr_backends.ideal import require_ideal
from cdpr_backends.mujoco.body import MujocoBackend


def make(robot: Robot, gravity: Array, physics_step: float, options: Any) -> Backend:
    """Return the backend for the chosen kind of cables."""
    if options.cables == "ups":
        from cdpr_backends.mujoco.legs import MujocoUps

        return MujocoUps(robot, gravity, physics_step, options)
    if options.cables == "native":
        from cdpr_backends.mujoco.tendons import MujocoTendons

        require_ideal(robot, options.cables)
        return MujocoTendons(robot, gravity, physics_step, options)
    return MujocoBackend(robot, gravity, physics_step, options)
