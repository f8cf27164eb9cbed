"""Conversion of a scenario or robot into the data of an export."""

from __future__ import annotations

import numpy as np

from cdpr.formats.write.export_model import Subject
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.scenario import Scenario
from cdpr.scenario.schema import World

STEP = 0.001  # s, for a robot without a scenario


def begin(loaded: Scenario | Robot) -> Subject:
    """Return a scenario's robot in its initial state, or a robot at rest at its home."""
    if isinstance(loaded, Robot):
        state = np.concatenate([home_pose(loaded)[0], np.zeros(6)])
        return Subject(loaded, np.array(World().gravity), state, STEP)
    gravity, step = np.array(loaded.world.gravity), loaded.simulation.physics_step
    state, actuated = loaded.initial.state(), loaded.actuators is not None
    return Subject(loaded.robot, gravity, state, step, actuated, len(loaded.events))
