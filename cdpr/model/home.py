"""Pose at which a robot is described."""

from __future__ import annotations

import numpy as np

from cdpr.model.robot import Array, Robot, middle

UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def home_pose(robot: Robot) -> tuple[Array, str]:
    """Return the pose (7,) at which a robot is described, and its origin in words.

    It contains the position [m] and the quaternion w, x, y, z. It is the home pose of the robot. Without one, it is
    upright in the middle of the frame's anchors. If all anchors are at one level, cables cannot lift the platform
    there, so the pose is lowered by a quarter of the anchors' extent.
    """
    if robot.home is not None:
        return robot.home, "home"
    A = robot.anchors[:, :3]
    position = middle(A, robot.dof)
    where = "below the middle" if position[2] < A[:, 2].mean() else "middle"
    return np.concatenate([position, UPRIGHT]), f"no home given: {where} of the frame's anchors"
