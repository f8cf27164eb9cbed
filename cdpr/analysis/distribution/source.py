"""Robot, gravity and solver options of a distribution, from any description of a robot."""

from __future__ import annotations

from numpy.typing import ArrayLike
from pydantic import BaseModel

from cdpr.model import Robot
from cdpr.scenario import Scenario
from cdpr.scenario.loader import AnyRobot, robot_or_scenario
from cdpr.scenario.sound_robot import sound

DOWN = (0.0, 0.0, -9.81)  # m/s^2


def robot_and_gravity(source: AnyRobot, gravity: ArrayLike | None) -> tuple[Robot, ArrayLike]:
    """Return the robot whose tensions are distributed, and gravity, (3,), m/s^2.

    Of a scenario, these are the robot in its controlled directions, and its gravity unless one is given.

    Raises:
        ScenarioError: with all problems of the description.
    """
    loaded = sound(source) if type(source) is Robot else robot_or_scenario(source)
    if isinstance(loaded, Scenario):
        return loaded.controlled_robot, loaded.gravity if gravity is None else gravity
    return loaded, DOWN if gravity is None else gravity


def options_of(loaded: Robot | Scenario, solver: object) -> BaseModel | None:
    """Return a scenario's options of the solver with this name; None if it has another one, or for a robot."""
    if not isinstance(loaded, Scenario) or loaded.solver.type != solver:
        return None
    return loaded.solver_options
