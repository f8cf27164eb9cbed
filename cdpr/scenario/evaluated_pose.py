"""Pose at which a robot or scenario is analysed, and its gravity."""

from __future__ import annotations

import numpy as np

from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.scenario.scenario import Scenario
from cdpr.scenario.schema import World


def evaluated_pose(
    loaded: Scenario | Robot, pose: Array | None = None, source: str = "pose"
) -> tuple[Robot, Array, Array, str]:
    """Return robot, gravity (3,), m/s^2, pose (7,) as position (m) and quaternion, and the source of the pose.

    Without a `pose`, which comes from `source`, it is the initial pose of a scenario, or the home of a robot.
    """
    scenario = loaded if isinstance(loaded, Scenario) else None
    robot = loaded.robot if isinstance(loaded, Scenario) else loaded
    gravity = np.array(scenario.world.gravity if scenario else World().gravity)
    if pose is not None:
        return robot, gravity, pose, source
    if scenario is not None:
        return robot, gravity, scenario.initial.state()[:7], "initial"
    at, source = home_pose(robot)
    return robot, gravity, at, source
