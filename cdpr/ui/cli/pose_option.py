"""Poses and gravity for commands: pose of --pose, of the scenario or of the robot's home."""

from __future__ import annotations

import math
import re

import click
import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import DOF_NAMES, Array
from cdpr.model.rotations import from_rpy, held_upright
from cdpr.scenario import Scenario
from cdpr.scenario.evaluated_pose import evaluated_pose
from cdpr.scenario.plausible.angles import in_degrees
from cdpr.scenario.plausible.places import far_text
from cdpr.ui.cli.numbers import number

DEGREES = re.compile(r"([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)) ?deg\b")


def pose_and_gravity(loaded: Scenario | Robot, pose: str | None) -> tuple[Robot, Array, Array, str]:
    """Return robot, gravity (3,), pose (7,) as position and quaternion, and the source of the pose.

    Raises:
        BadParameter: if `pose`, the text of --pose, is invalid for the robot.
    """
    robot = loaded.robot if isinstance(loaded, Scenario) else loaded
    return evaluated_pose(loaded, None if pose is None else parse_pose(pose, robot), "--pose")


def parse_pose(text: str, robot: Robot) -> Array:
    """Return the position and quaternion (7,) of --pose."""
    numbers = _numbers(DEGREES.sub(lambda found: repr(math.radians(float(found[1]))), text))
    if len(numbers) not in (3, 6) or any("deg" in part for part in text.split(",")[:3]):
        hint = "expected three numbers x,y,z (m) or six with roll,pitch,yaw (rad, or as 30deg), such as 0,0,1.5"
        raise click.BadParameter(f"{hint}, got {text[:80]!r}", param_hint="--pose")
    if text := in_degrees(numbers[3:]):
        click.echo(f"warning: --pose: {text}", err=True)
    q = from_rpy(*(numbers[3:] or (0.0, 0.0, 0.0)))
    if not held_upright(robot.dof, q):
        hint = f"the robot moves along {', '.join(robot.dof)} only, so it cannot rotate about the other axes"
        raise click.BadParameter(hint, param_hint="--pose")
    position = np.array(numbers[:3])
    if text := far_text(robot, position):
        click.echo(f"warning: --pose: {text}", err=True)
    return np.concatenate([position, q])


def parse_attitude(text: str, robot: Robot) -> Array:
    """Return the quaternion (4,) of --orientation."""
    numbers = _numbers(DEGREES.sub(lambda found: repr(math.radians(float(found[1]))), text))
    if len(numbers) != 3:
        hint = "expected roll,pitch,yaw (rad, or as 30deg), such as 0,0,0.1"
        raise click.BadParameter(f"{hint}, got {text[:80]!r}", param_hint="--orientation")
    if problem := in_degrees(numbers):
        click.echo(f"warning: --orientation: {problem}", err=True)
    q = from_rpy(*numbers)
    if not held_upright(robot.dof, q):
        hint = f"the robot moves along {', '.join(robot.dof)} only, so it cannot rotate about the other axes"
        raise click.BadParameter(hint, param_hint="--orientation")
    return q


def parse_wrench(text: str, robot: Robot) -> Array:
    """Return the force and moment (6,) of --wrench; components in held directions must be 0."""
    numbers = _numbers(text)
    if len(numbers) not in (3, 6):
        hint = "expected three numbers fx,fy,fz (N) or six with mx,my,mz (N m), such as 0,0,500"
        raise click.BadParameter(f"{hint}, got {text[:80]!r}", param_hint="--wrench")
    wrench = np.zeros(6)
    wrench[: len(numbers)] = numbers
    held = [name for i, name in enumerate(DOF_NAMES) if name not in robot.dof and wrench[i] != 0.0]
    if held:
        hint = f"the robot moves along {', '.join(robot.dof)} only, so no wrench is required along the other axes"
        raise click.BadParameter(f"{hint}: give 0 for {', '.join(held)}", param_hint="--wrench")
    return wrench


def _numbers(text: str) -> list[float]:
    """Return the finite numbers between commas; an empty list if any is invalid."""
    try:
        numbers = [number(part) for part in text.split(",")]
    except ValueError:
        return []
    return numbers if all(math.isfinite(number) for number in numbers) else []
