"""Static feasibility by projections, compared with a linear program."""

import numpy as np
import pytest
from conftest import GRAVITY
from scipy.optimize import linprog

from cdpr.scenario import load_scenario
from cdpr.scenario.static_feasibility import held, weight, wrench_matrix

CLEAR = 0.02  # of the tension range: with such a distance to the limits, projections must succeed


def distance(robot, position, attitude) -> float:
    """Return the largest distance to the limits that tensions can keep, relative to the range; -1 if there are none."""
    W, wanted = wrench_matrix(robot, position, attitude), weight(robot, attitude, GRAVITY)
    low, high = robot.tension_min, robot.tension_max
    span = (high - low)[:, None]
    sides = np.block([[np.eye(robot.m), span], [-np.eye(robot.m), span]])
    answer = linprog(
        np.append(np.zeros(robot.m), -1.0),
        A_eq=np.hstack([W, np.zeros((len(W), 1))]),
        b_eq=wanted,
        A_ub=sides,
        b_ub=np.concatenate([high, -low]),
        bounds=[(None, None)] * (robot.m + 1),
    )
    return float(answer.x[-1]) if answer.status == 0 else -1.0


@pytest.mark.parametrize(("name", "reach"), [("caroca", 4.0), ("planar", 3.0), ("cogiro", 8.0)])
def test_poses_are_judged_as_by_a_linear_program(name, reach):
    robot = load_scenario(name).robot
    positions = robot.home[:3] + np.random.default_rng(3).uniform(-reach, reach, (25, 3))
    positions[:, [axis not in robot.dof for axis in "xyz"]] = 0.0
    found = held(robot, positions, robot.home[3:], GRAVITY)
    distances = np.array([distance(robot, position, robot.home[3:]) for position in positions])
    assert found[distances > CLEAR].all()
    assert not found[distances < 0.0].any()
    assert found.any()
    assert (distances < 0.0).any()
