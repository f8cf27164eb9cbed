"""Robot objects pass the checks of robot files where they are saved or used, and are read back unchanged."""

from __future__ import annotations

import math

import numpy as np
import pytest

import cdpr
from cdpr.model import Box, Frame, Mesh, Winch

pytestmark = pytest.mark.core

SIGNS = [[1, -1, -1], [-1, 1, 1], [-1, -1, 1], [1, 1, -1], [-1, -1, -1], [1, 1, 1], [1, -1, 1], [-1, 1, -1]]
POINTS = 0.5 * np.array(SIGNS) * [0.6, 0.4, 0.2]
FRAME = np.repeat([[-2.0, -1.5, 3.0], [2.0, -1.5, 3.0], [-2.0, 1.5, 3.0], [2.0, 1.5, 3.0]], 2, axis=0)


def built(**changes):
    given = {"frame": FRAME, "platform": POINTS, "mass": 12.0, "home": [0, 0, 1.2], "tension_max": 800.0}
    return cdpr.Robot.from_points(**given | changes)


def with_platform(**changes):
    return built().replace(platform=built().platform.replace(**changes))


def with_cable(**changes):
    robot = built()
    return robot.replace(cables=(robot.cables[0].replace(**changes), *robot.cables[1:]))


UNSOUND = {
    "name": (lambda: built(name="my robot"), "name: expected a name"),
    "tool": (lambda: with_platform(tools={"a b": [0, 0, 0]}), "platform.tools.'a b': expected a name"),
    "cable": (lambda: with_cable(name="a/b"), "cables[0].name: expected a name"),
    "surrogate": (lambda: built(name="a\ud800"), "name: expected a text of valid characters"),
    "negative": (lambda: built(inertia=-np.eye(3)), "platform.inertia: no rigid body has this inertia"),
    "triangle": (lambda: built(inertia=[1, 1, 5]), "platform.inertia: no rigid body has this inertia"),
    "one": (lambda: built(inertia=[0, 0, 3]), "platform.inertia: no rigid body has this inertia"),
    "mass": (lambda: built(mass=1e13), "platform.mass: must lie between"),
    "tension": (lambda: built(tension_max=1e13), "tension.max: must lie between"),
    "anchor": (lambda: with_cable(frame=[1e9, 0, 0]), "cables[0].frame[0]: must lie between"),
    "home": (lambda: built(home=[0, 0, 1e9]), "home.position[2]: must lie between"),
    "mesh": (lambda: with_platform(shape=Mesh("no.stl", (0, 0, 0), (1, 1, 1))), "platform.shape.mesh: "),
    "dof": (lambda: built(dof=("ry", "rz")), "dof: no guide leaves ry, rz free"),
    "length": (lambda: with_cable(length_min=3.0, length_max=2.0), "cables[0].length: min (3 m) must not exceed"),
    "speed": (lambda: with_cable(speed_max=0.0), "cables[0].speed_max: must be greater than 0"),
    "elastic": (lambda: built().replace(cable_model="elastic"), "cable.model elastic needs the winch of each cable"),
    "winch": (lambda: with_cable(model="rigid", winch=Winch(drum_radius=0.0, inertia=0.1)), "winch.drum_radius: must"),
    "crowd": (lambda: built(frame=np.eye(257, 3), platform=np.zeros((257, 3)), dof=["x"]), "256"),
}


@pytest.mark.parametrize("name", UNSOUND)
def test_unsound_robots_are_neither_saved_nor_used(name, tmp_path):
    make, text = UNSOUND[name]
    robot = make()
    uses = (
        lambda: robot.to_dict(),
        lambda: robot.save(tmp_path / "x.yaml"),
        lambda: cdpr.load_robot(robot),
        lambda: cdpr.distribute(robot, [0, 0, 1.2, 1, 0, 0, 0]),
    )
    for use in uses:
        with pytest.raises(cdpr.ScenarioError) as caught:
            use()
        assert text in str(caught.value)
    assert not (tmp_path / "x.yaml").exists()


def tilted():
    return {"orientation": {"rpy": [0.1, 0.2, 0.3]}, "lower": [-2, -2, 0], "upper": [2, 2, 3], "colour": "red"}


KEPT = {
    "frame": lambda: cdpr.load_robot(built().to_dict() | {"frame": tilted()}),
    "posts": lambda: cdpr.load_robot(built().to_dict() | {"frame": tilted() | {"shape": "posts"}}),
    "edges": lambda: built().replace(frame=Frame(np.arange(18.0).reshape(3, 6), "#AABBCC")),
    "colour": lambda: with_platform(colour="red"),
    "box": lambda: with_platform(shape=Box([1.0, 2.0, 3.0])),
    "minus": lambda: built(home=[0, 0, 1.2, 1, -0.0, 0, 0]),
    "turned": lambda: built(home=[0, 0, 1.2, math.cos(0.3), 0, 0, math.sin(0.3)]),
    "plain": built,
}


@pytest.mark.parametrize("name", KEPT)
def test_saved_robots_are_read_back_unchanged(name, tmp_path):
    robot = KEPT[name]()
    robot.save(tmp_path / "robot.yaml")
    found = cdpr.load_robot(tmp_path / "robot.yaml")
    assert found == robot
    assert found.home.tobytes() == robot.home.tobytes()
    assert cdpr.load_robot(robot, overrides={"platform.mass": 12.0}) == robot


def test_frames_are_either_boxes_or_edges():
    data = built().to_dict() | {"frame": {"edges": [[0, 0, 0, 1, 1, 1]], "shape": "posts"}}
    with pytest.raises(cdpr.ScenarioError, match="frame: expected either edges, or shape, lower and upper"):
        cdpr.load_robot(data)


def test_foreign_exits_are_refused(tmp_path):
    class Mine:
        def numbers(self):
            return []

    robot = with_cable(exit=Mine())
    for use in (robot.to_dict, lambda: robot.save(tmp_path / "x.yaml"), lambda: cdpr.load_robot(robot)):
        with pytest.raises(cdpr.ScenarioError, match=r"cables.cable_1.exit: expected an exit such as .* got .* Mine"):
            use()
