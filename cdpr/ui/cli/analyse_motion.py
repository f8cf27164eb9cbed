"""Figures and pictures of a robot or a scenario for `cdpr info` and `cdpr view`."""

from __future__ import annotations

from typing import Any

from cdpr.analysis.distribution.motion import describe_loaded
from cdpr.analysis.distribution.survey import Survey
from cdpr.analysis.workspace.path import along
from cdpr.model import Robot
from cdpr.scenario import Scenario
from cdpr.scene import Pictures, Subject
from cdpr.ui.cli.pose_option import pose_and_gravity
from cdpr.ui.report.plots.survey import pose_pictures, survey_pictures


def portray(loaded: Scenario | Robot, pose: str | None) -> tuple[dict[str, Any], Pictures, Survey | None]:
    """Return figures as plain data, pictures, and for a scenario its motion, without simulation.

    Raises:
        BadParameter: if `pose`, the text of --pose, is invalid for the robot.
    """
    robot, gravity, at, source = pose_and_gravity(loaded, pose)
    figures, motion = describe_loaded(loaded, gravity, at, source)
    if motion is not None and isinstance(loaded, Scenario):
        poses = motion.desired[:, :7]
        figures["motion"]["least"] = along(loaded.controlled_robot, motion.time, poses, gravity, loaded.obstacles)
    subject = Subject.of_robot(robot)
    return figures, pose_pictures(at, subject) if motion is None else survey_pictures(motion, subject), motion
