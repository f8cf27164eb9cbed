"""From a scenario or a robot file to what is exported."""

from __future__ import annotations

import numpy as np

from cdpr.formats.write.subject import Subject
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.scenario import Scenario
from cdpr.scenario.schema import World

STEP = 0.001  # s, where nothing says another


def begin(loaded: Scenario | Robot) -> Subject:
    """Return a scenario's robot as it begins, or a robot at rest at its home."""
    if isinstance(loaded, Robot):
        state = np.concatenate([home_pose(loaded)[0], np.zeros(6)])
        return Subject(loaded, np.array(World().gravity), state, STEP)
    step = float(loaded.simulation.physics_step or STEP)
    actuated = loaded.actuators is not None
    gravity, state = np.array(loaded.world.gravity), loaded.initial.state()
    return Subject(loaded.robot, gravity, state, step, actuated, len(loaded.events))
