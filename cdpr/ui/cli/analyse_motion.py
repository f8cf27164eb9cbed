"""Figures and pictures of a robot or a scenario for `cdpr info` and `cdpr view`."""

from __future__ import annotations

from typing import Any

from cdpr.analysis.distribution.survey import Survey
from cdpr.model import Robot
from cdpr.scenario import Scenario
from cdpr.scene import Pictures
from cdpr.ui.cli.pose_option import pose_and_gravity
from cdpr.ui.report.view import analysed


def portray(loaded: Scenario | Robot, pose: str | None) -> tuple[dict[str, Any], Pictures, Survey | None]:
    """Return figures as plain data, pictures, and for a scenario its motion, without simulation.

    Raises:
        BadParameter: if `pose`, the text of --pose, is invalid for the robot.
    """
    _, gravity, at, source = pose_and_gravity(loaded, pose)
    return analysed(loaded, gravity, at, source)
