"""Workspaces where cables are slack, locked or too few: what an attack found."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from test_workspace import robot_of

from cdpr.scenario import load_robot
from cdpr.workspace.regions import Region
from cdpr.workspace.required import box
from cdpr.workspace.result import workspace

ONE_SLACK = """
name: slack
dof: [x, z]
platform: {mass: 5, shape: {sphere: 0.05}}
tension: {min: 0, max: 500}
home: {position: [0, 0, 1]}
cable: {axial_stiffness: 1.0e5}
cables:
- {frame: [0, 0, 3], platform: [0, 0, 0]}
- {frame: [-2, 0, 1], platform: [0, 0, 0]}
"""
UPRIGHT = np.array([[1.0, 0.0, 0.0, 0.0]])


def around_home(robot, size=0.001):
    half = np.array([size, 0.0, size])
    return Region(robot.home[:3] - half, robot.home[:3] + half, (1, 1, 1), UPRIGHT)


def test_a_slack_cable_is_no_spring(tmp_path):
    """A mass that hangs on the other one swings as a pendulum: m g / l along x."""
    robot = load_robot(tmp_path / "slack.yaml", text=ONE_SLACK)
    for kind in ("stiffness", "stable"):
        found = workspace(robot, kind, around_home(robot))
        assert found.value.item() == pytest.approx(5 * 9.81 / 2.0, rel=1e-9)
    hertz = workspace(robot, "frequency", around_home(robot)).value.item()
    assert hertz == pytest.approx(np.sqrt(9.81 / 2.0) / (2 * np.pi), rel=1e-9)


def test_stiff_along_one_direction_is_not_inside_where_it_falls_over(tmp_path):
    above = ONE_SLACK.replace("[0, 0, 3]", "[0, 0, -1]").replace("[-2, 0, 1]", "[0, 0, -1.5]")
    robot = load_robot(tmp_path / "tip.yaml", text=above)
    found = workspace(robot, "stiffness", around_home(robot), gravity=(0, 0, 9.81), direction="z")
    assert not found.inside.any() or workspace(robot, "stable", around_home(robot), gravity=(0, 0, 9.81)).inside.all()


def test_closure_does_not_depend_on_limits():
    robot = robot_of("planar")
    place = Region(np.array([-1.0, 0, 0.5]), np.array([1.0, 0, 2.5]), (9, 1, 9), UPRIGHT)
    first, *rest = robot.cables
    locked = dataclasses.replace(first, tension_min=100.0, tension_max=100.0)
    weighted = dataclasses.replace(robot, cables=(locked, *rest))
    plain = workspace(robot, "closure", place)
    assert plain.inside.any()
    assert np.array_equal(workspace(weighted, "closure", place).inside, plain.inside)


def test_what_lies_in_the_range_of_a_matrix_without_rank_is_feasible():
    """Four cables in a plane, of a point that may leave it: wrenches in the plane are exerted, no others are."""
    point = robot_of("point_mass")
    frames = [(-2.0, 0.0, 3.0), (2.0, 0.0, 3.0), (-2.0, 0.0, 2.0), (2.0, 0.0, 2.0)]
    flat = [dataclasses.replace(point.cables[0], name=f"c{k}", frame=np.array(at)) for k, at in enumerate(frames)]
    robot = dataclasses.replace(point, cables=tuple(flat), frame=None)
    place = Region(np.array([-1.0, -0.5, 0.5]), np.array([1.0, 0.5, 1.5]), (4, 1, 4), UPRIGHT)
    static = workspace(robot, "static", place)
    assert static.inside.any()
    nothing = workspace(robot, "wrench-feasible", place, required=box([0, 0, 0, 0, 0, 0]))
    assert np.array_equal(nothing.inside, static.inside)
    within = workspace(robot, "wrench-feasible", place, required=box([1, 0, 1, 0, 0, 0]))
    assert within.inside.any()
    across = workspace(robot, "wrench-feasible", place, required=box([0, 1, 0, 0, 0, 0]))
    assert not across.inside.any()
