"""Robots, platforms and cables from arrays: defaults, equality, copies, and one clear error for each wrong argument."""

from __future__ import annotations

import copy
import math
import pickle

import numpy as np
import pytest

import cdpr

pytestmark = pytest.mark.core

SIGNS = [[1, -1, -1], [-1, 1, 1], [-1, -1, 1], [1, 1, -1], [-1, -1, -1], [1, 1, 1], [1, -1, 1], [-1, 1, -1]]
POINTS = 0.5 * np.array(SIGNS) * [0.6, 0.4, 0.2]
FRAME = np.repeat([[-1.5, -1.5, 3.0], [2.5, -1.5, 3.0], [-1.5, 1.5, 3.0], [2.5, 1.5, 3.0]], 2, axis=0)


def built(**changes):
    return cdpr.Robot.from_points(**{"frame": FRAME, "platform": POINTS, "mass": 12.0} | changes)


def test_defaults():
    robot = built()
    assert robot.home.tolist() == [0.5, 0.0, 3.0 - 0.25 * 5.0, 1.0, 0.0, 0.0, 0.0]  # anchors at one level
    assert built(frame=[*FRAME[:7], [2.5, 1.5, 1.0]]).home.tolist() == [0.5, 0.0, 2.75, 1.0, 0.0, 0.0, 0.0]
    assert np.allclose(np.diag(robot.platform.inertia), [0.16 + 0.04, 0.36 + 0.04, 0.36 + 0.16])  # m / 12 (b^2 + c^2)
    assert (set(robot.tension_min), set(robot.tension_max)) == ({0.0}, {math.inf})
    assert [cable.name for cable in robot.cables] == [f"cable_{i}" for i in range(1, 9)]
    assert not robot.platform.inertia.flags.writeable
    assert np.array_equal(robot.anchors, np.concatenate([FRAME, POINTS], axis=1))


def test_the_callers_array_is_copied():
    frame = FRAME.copy()
    robot = built(frame=frame)
    frame[0] = 7.0
    assert robot.anchors[0, 0] == FRAME[0, 0]


def test_given_values():
    robot = built(inertia=[1, 2, 2.5, 0.1, 0, 0], tension_max=range(100, 180, 10), home=[0, 0, 1, 0, 0, 0, 1.0001])
    assert robot.platform.inertia.tolist() == [[1.0, 0.1, 0.0], [0.1, 2.0, 0.0], [0.0, 0.0, 2.5]]
    assert robot.tension_max.tolist() == [100.0 + 10.0 * i for i in range(8)]
    assert robot.home.tolist() == [0, 0, 1, 0, 0, 0, 1]
    point = built(platform=np.zeros((8, 3)), dof=("x", "y", "z"))
    assert point.platform.inertia.tolist() == np.eye(3).tolist()


def test_equality_and_copies():
    robot = built()
    for other in (built(), copy.deepcopy(robot), pickle.loads(pickle.dumps(robot)), robot.replace()):
        assert other == robot
        assert hash(other) == hash(robot)
    assert robot != built(mass=12.5)
    assert robot.replace(home=[0, 0, 1]) != robot
    lighter = robot.replace(platform=robot.platform.replace(mass=3.0))
    assert lighter.platform.mass == 3.0
    assert robot.platform.mass == 12.0
    assert robot != "robot"


WRONG = {
    "frame-shape": ({"frame": FRAME[:, :2]}, "from_points(frame=): expected any number x 3 numbers, got 8 x 2"),
    "frame-nan": ({"frame": FRAME + np.nan}, "from_points(frame=): expected finite numbers, got nan"),
    "frame-text": ({"frame": "corners"}, "from_points(frame=): expected real numbers"),
    "frame-ragged": ({"frame": [[1, 2], [3]]}, "from_points(frame=): expected numbers"),
    "tension-column": ({"tension_max": np.ones((8, 1))}, "expected one number or 8, one per cable, got 8 x 1"),
    "tension-one": ({"tension_max": [9, 9, -1, 9, 9, 9, 9, 9]}, "from_points(tension_max=)[2]: expected a number of"),
    "frame-none": ({"frame": np.zeros((0, 3))}, "from_points(frame=): expected at least one point"),
    "platform-count": ({"platform": POINTS[:7]}, "from_points(platform=): expected as many points as frame, 8, got 7"),
    "mass-negative": ({"mass": -1}, "from_points(mass=): expected a number greater than 0, got -1"),
    "mass-text": ({"mass": "12 kg"}, "from_points(mass=): expected a number greater than 0, got '12 kg'"),
    "mass-nan": ({"mass": math.nan}, "from_points(mass=): expected a number greater than 0, got nan"),
    "mass-true": ({"mass": True}, "from_points(mass=): expected a number"),
    "inertia-shape": ({"inertia": [1, 2]}, "Platform(inertia=): expected 3 x 3, 3 or 6 numbers, got 2"),
    "inertia-order": ({"inertia": np.arange(9).reshape(3, 3)}, "Platform(inertia=): expected a symmetric tensor"),
    "inertia-lacks": ({"platform": 0 * POINTS}, "from_points(inertia=): required, because the points"),
    "centre": ({"center_of_mass": [0, 0]}, "Platform(center_of_mass=): expected 3 numbers, got 2"),
    "tension-order": (
        {"tension_min": 5, "tension_max": 4},
        "from_points(tension_max=)[0]: expected a number of at least 5, got 4",
    ),
    "tension-count": (
        {"tension_max": [1, 2]},
        "from_points(tension_max=): expected one number or 8, one per cable, got",
    ),
    "tension-push": ({"tension_min": -5}, "Robot(cables=)[0]: tension_min must be at least 0 N, got -5"),
    "home": ({"home": [0, 0]}, "Robot(home=): expected 3 or 7 numbers, got 2"),
    "home-turn": ({"home": [0, 0, 1, 1, 1, 0, 0]}, "Robot(home=): expected a quaternion of norm 1, got norm 1.41421"),
    "dof": ({"dof": ["y", "x"]}, "Robot(dof=): expected some of x, y, z, rx, ry, rz, in this order, got"),
    "name": ({"name": 3}, "Robot(name=): expected a text, got 3"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_arguments(name):
    changes, text = WRONG[name]
    with pytest.raises(cdpr.CdprError) as caught:
        built(**changes)
    assert text in str(caught.value)
    assert "\n" not in str(caught.value)


def test_wrong_parts():
    robot = built()
    for make, text in (
        (lambda: robot.replace(mas=3), "Robot(mas=): unknown: "),
        (lambda: robot.replace(platform=3), "Robot(platform=): expected a cdpr.Platform, got 3"),
        (lambda: robot.replace(cables=[]), "Robot(cables=): expected a list of cdpr.Cable, got an empty list"),
        (lambda: robot.replace(cables=[robot.cables[0]] * 2), "Robot(cables=)[1]: 'cable_1' is the name of another"),
        (lambda: cdpr.Cable([0, 0, 0], [0, 0, 1], diameter=-1), "Cable(diameter=): expected a number of at least 0"),
        (lambda: cdpr.Cable([0, 0, 0], [0, 0, 1], winch=3), "Cable(winch=): expected a cdpr.model.Winch, got 3"),
        (lambda: cdpr.Platform(1, [1, 1, 1], tools={"tip": [1]}), "Platform(tools=)['tip']: expected 3 numbers, got 1"),
    ):
        with pytest.raises(cdpr.CdprError) as caught:
            make()
        assert text in str(caught.value)
