"""Workspaces where cables are slack, locked or too few: what an attack found."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from workspace_cases import cli, robot_of

from cdpr.analysis.workspace.oracle import compare
from cdpr.analysis.workspace.regions import Region, region
from cdpr.analysis.workspace.required import box
from cdpr.analysis.workspace.result import load_workspace, workspace
from cdpr.base.errors import LogError
from cdpr.scenario import load_robot
from cdpr.scenario.robot_schema import CHECKED

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


def flat():
    """A point that may leave the plane of its four cables."""
    point = robot_of("point_mass")
    frames = [(-2.0, 0.0, 3.0), (2.0, 0.0, 3.0), (-2.0, 0.0, 2.0), (2.0, 0.0, 2.0)]
    cables = [dataclasses.replace(point.cables[0], name=f"c{k}", frame=np.array(at)) for k, at in enumerate(frames)]
    return dataclasses.replace(point, cables=tuple(cables), frame=None)


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


@pytest.mark.slow
def test_wrenches_in_the_range_of_rank_deficient_matrices_are_feasible():
    """Four cables in a plane, of a point that may leave it: wrenches in the plane are exerted, no others are."""
    robot = flat()
    place = Region(np.array([-1.0, -0.5, 0.5]), np.array([1.0, 0.5, 1.5]), (4, 1, 4), UPRIGHT)
    static = workspace(robot, "static", place)
    assert static.inside.any()
    nothing = workspace(robot, "wrench-feasible", place, required=box([0, 0, 0, 0, 0, 0]))
    assert np.array_equal(nothing.inside, static.inside)
    within = workspace(robot, "wrench-feasible", place, required=box([1, 0, 1, 0, 0, 0]))
    assert within.inside.any()
    across = workspace(robot, "wrench-feasible", place, required=box([0, 1, 0, 0, 0, 0]))
    assert not across.inside.any()


@pytest.mark.slow
def test_payload_in_a_plane_without_rank():
    """Four cables of a point in a plane: there are masses that they carry, and more than they can."""
    robot = flat()
    place = Region(np.array([-0.1, -0.1, 0.9]), np.array([0.1, 0.1, 1.1]), (1, 1, 1), UPRIGHT)
    most = 0.0
    for mass in np.geomspace(0.1, 1e4, 40):
        if workspace(robot, "payload", place, at_least=float(mass)).inside.all():
            most = float(mass)
    heavier = dataclasses.replace(robot, platform=dataclasses.replace(robot.platform, mass=robot.platform.mass + most))
    assert most > 0.1
    assert workspace(heavier, "static", place).inside.all()
    assert not workspace(robot, "payload", place, at_least=1e4).inside.any()


@pytest.mark.slow
def test_poses_within_1e_9_of_where_w_lacks_rank_are_reported_not_different():
    """A hair off the plane the program's tolerance carries what W, which has rank there, does not."""
    robot = flat()
    told = {}
    for off in (0.0, 2e-9, 1e-6):
        half, middle = np.array([0.5, 0.5, 0.5]), np.array([0.0, off, 1.0])
        found = workspace(robot, "static", Region(middle - half, middle + half, (5, 1, 5), UPRIGHT))
        told[off] = compare(found, robot, 12)
        assert told[off].different == []
        assert found.inside.all() == (off == 0.0)
    assert len(told[2e-9].near) > 5
    assert told[0.0].near == told[1e-6].near == []


def test_infinite_values_of_an_octree_are_silent(recwarn):
    robot = robot_of("caroca")
    found = workspace(robot, "stable", region(robot, cells=16), method="octree")
    assert np.isposinf(found.value).any()
    assert not recwarn.list


@pytest.mark.slow
@pytest.mark.parametrize("name", ["about", "inside", "orientations", "lower", "value", "x", "box_level"])
def test_a_changed_file_is_reported(tmp_path, name):
    robot = robot_of("planar")
    workspace(robot, "static", region(robot, cells=4), method="certify", undecided=0.5).save(tmp_path / "w.npz")
    with np.load(tmp_path / "w.npz") as kept:
        parts = dict(kept)
    if name == "about":
        parts[name] = np.array(str(parts[name]).replace("9.81", "9.82"))
    elif name == "box_level":
        parts[name] = parts[name][:-1]
    else:
        parts[name] = parts[name].astype(float) + 0.5
    np.savez(tmp_path / "changed.npz", **parts)
    with pytest.raises(LogError, match=r"cannot be read as a workspace \(it has changed since it was written"):
        load_workspace(tmp_path / "changed.npz")


def test_cables_that_are_as_near_as_they_are_thick_on_both_sides_touch():
    robot = robot_of("caroca")
    found = workspace(robot, "ifcow", region(robot, cells=3), diameter=1e308)
    assert not found.inside.any()
    twins = [dataclasses.replace(robot.cables[0], name=name) for name in ("one", "other")]
    double = dataclasses.replace(robot, cables=(*twins, *robot.cables[3:]))
    vars(double)[CHECKED] = True  # robot files reject equal cables
    assert "one and other" in " ".join(workspace(double, "ifcow", region(robot, cells=3), diameter=0.01).about["notes"])


@pytest.mark.slow
def test_the_oracle_is_in_the_summary(tmp_path):
    file = tmp_path / "w.npz"
    done = cli("workspace", "static", "planar", "--cells", "6", "--oracle", "lp", "--out", file)
    assert done.returncode == 0, done.stderr
    (line,) = [line for line in done.stdout.splitlines() if "verified by lp" in line]
    assert "200 poses: 0 different" in line
    assert load_workspace(file).summary()["oracle"]["poses"] == 200
