"""Robots given as objects: checked like a robot file, once per object."""

from __future__ import annotations

import os
from typing import Any

from cdpr.config.problems import Problems
from cdpr.config.validation import validate
from cdpr.model import Robot
from cdpr.scenario import from_python
from cdpr.scenario.checks import remember
from cdpr.scenario.named_files import files_of_robot
from cdpr.scenario.robot_checks import RobotChecks
from cdpr.scenario.robot_schema import CHECKED, RobotSection
from cdpr.scenario.source import accept_absolute


def sound(robot: Robot) -> Robot:
    """Return the robot.

    Raises:
        ScenarioError: with all problems, by key, if no robot file can describe it.
    """
    if CHECKED not in vars(robot):
        document = from_python.document_of(from_python.robot_data(robot))
        accept_absolute(document, list(files_of_robot(document.data)))
        problems = Problems()
        section = validate(RobotSection, document.data, document, problems)
        if section is not None:
            remember(section, document)
        RobotChecks(document, problems).run(())
        problems.raise_any()
        vars(robot)[CHECKED] = True  # beside the fields, as `cached_property` does; robots are frozen
    return robot


def robot_dict(robot: Robot) -> dict[str, Any]:
    """Return a robot as plain data; see `Robot.to_dict`."""
    return from_python.robot_data(sound(robot))


def save_robot(robot: Robot, path: str | os.PathLike[str]) -> None:
    """Write a robot as YAML; see `Robot.save`."""
    from_python.save_robot(sound(robot), path)
