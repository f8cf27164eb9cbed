"""cdpr.admissible: the null space, corners, ranges, margin and sensitivity of all tensions that balance a wrench."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from conftest import ROOT
from scipy.optimize import linprog

import cdpr
from cdpr.base.errors import CdprError
from cdpr.mechanics.properties import home_pose

pytestmark = pytest.mark.core

AT = [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]


def load(name):
    return cdpr.load_robot(ROOT / "scenarios" / "robots" / f"{name}.yaml")


@pytest.fixture(scope="module")
def found():
    names = ("point_mass", "planar", "caroca", "nine", "twelve")
    robots = {name: load(name) for name in names}
    return {name: (robot, cdpr.admissible(robot, home_pose(robot)[0])) for name, robot in robots.items()}


@pytest.mark.parametrize(("name", "r"), [("point_mass", 0), ("planar", 1), ("caroca", 2), ("nine", 3), ("twelve", 6)])
def test_against_linear_programs_and_algebra(found, name, r):
    robot, a = found[name]
    assert a.redundancy == r
    assert a.feasible
    np.testing.assert_allclose(a.basis.T @ a.basis, np.eye(r), atol=1e-12)
    np.testing.assert_allclose(a.W @ a.basis, 0.0, atol=1e-12)
    np.testing.assert_allclose(a.W @ a.particular, a.wrench, atol=1e-9)
    np.testing.assert_allclose(a.particular, np.linalg.pinv(a.W) @ a.wrench, atol=1e-9)
    bounds = np.array([robot.tension_min, robot.tension_max]).T
    for i in range(robot.m):
        for side, sign in enumerate((1.0, -1.0)):
            best = linprog(sign * np.eye(robot.m)[i], None, None, a.W, a.wrench, bounds)
            assert a.range[i, side] == pytest.approx(best.x[i], abs=1e-6)
    np.testing.assert_allclose(a.W @ a.safest, a.wrench, atol=1e-9)
    room = np.minimum(a.safest - robot.tension_min, robot.tension_max - a.safest)
    assert room.min() == pytest.approx(a.margin, abs=1e-6)
    np.testing.assert_array_equal(np.flatnonzero(a.active), np.flatnonzero(room <= a.margin + 1e-6))
    if r > 3:
        assert a.vertices is None
        return
    # The corners keep all limits, each lies on r of them, and they reach each end of each range.
    np.testing.assert_allclose(a.vertices @ a.W.T, np.tile(a.wrench, (len(a.vertices), 1)), atol=1e-8)
    np.testing.assert_allclose(a.vertices.min(axis=0), a.range[:, 0], atol=1e-8)
    np.testing.assert_allclose(a.vertices.max(axis=0), a.range[:, 1], atol=1e-8)
    at = np.minimum(a.vertices - robot.tension_min, robot.tension_max - a.vertices)
    assert (at >= 0.0).all()
    assert ((at < 1e-7).sum(axis=1) >= r).all()


def test_sensitivity_is_the_change_of_the_particular_solution(found):
    robot, a = found["caroca"]
    wrench = np.zeros(6)
    wrench[robot.rows] = a.wrench
    for j in range(6):
        more = cdpr.admissible(robot, home_pose(robot)[0], wrench + np.eye(6)[j])
        np.testing.assert_allclose(more.particular - a.particular, a.sensitivity[:, j], atol=1e-9)


def test_a_locked_cable_is_given():
    robot = load("caroca")
    cables = (replace(robot.cables[0], tension_min=300.0, tension_max=300.0), *robot.cables[1:])
    a = cdpr.admissible(replace(robot, cables=cables), AT)
    assert a.redundancy == 1
    assert a.range[0].tolist() == [300.0, 300.0]
    assert a.active[0] == 0
    np.testing.assert_array_equal(a.sensitivity[0], 0.0)
    np.testing.assert_array_equal(a.vertices[:, 0], 300.0)


def test_infeasible_and_out_of_reach():
    robot = load("caroca")
    a = cdpr.admissible(robot, AT, [0.0, 0.0, -1e5, 0.0, 0.0, 0.0])
    assert a.reachable
    assert not a.feasible
    assert a.margin < 0.0
    assert np.isnan(a.range).all()
    assert len(a.vertices) == 0
    few = cdpr.admissible(replace(robot, cables=robot.cables[:4]), AT, [0.0, 0.0, 1e3, 9.0, 9.0, 9.0])
    assert not few.reachable
    assert few.margin == -np.inf
    assert few.vertices is None
    assert np.isnan(few.particular).all()


def test_it_is_frozen(found):
    a = found["planar"][1]
    with pytest.raises(FrozenInstanceError):
        a.margin = 0.0
    for name in ("W", "wrench", "particular", "basis", "vertices", "range", "safest", "active", "sensitivity"):
        assert not getattr(a, name).flags.writeable, name


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((["caroca.yaml"], AT), "robot: .* got a list"),
        ((None, [AT]), r"pose: the shape must be \(7,\), got \(1, 7\)"),
        ((None, [np.nan, *AT[1:]]), "pose: all numbers must be finite"),
        ((None, [0.0] * 7), r"pose: expected a quaternion of norm 1, got norm 0"),
        ((None, AT, [1.0]), r"wrench: the shape must be \(6,\), got \(1,\)"),
    ],
)
def test_wrong_input_is_reported(arguments, text):
    robot, *others = arguments
    with pytest.raises(CdprError, match=text):
        cdpr.admissible(robot or load("planar"), *others)


def test_infinite_limits_are_reported():
    robot = load("planar")
    cables = tuple(replace(cable, tension_max=np.inf) for cable in robot.cables)
    with pytest.raises(CdprError, match="limits: expected finite limits"):
        cdpr.admissible(replace(robot, cables=cables), AT)


def test_names_at_the_top_and_where_they_were():
    assert {"admissible", "distribute"} <= set(cdpr.__all__)
