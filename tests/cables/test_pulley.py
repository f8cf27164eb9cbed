"""The swivelling pulley against geometry that knows nothing of its closed form."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT, crossed_box, make_robot, moved, random_state
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from cdpr.base.errors import CdprError, PluginError, ScenarioError
from cdpr.cables import Point, Pulley
from cdpr.mechanics import kinematics
from cdpr.mechanics.forward_kinematics import forward_kinematics
from cdpr.mechanics.properties import check_lengths
from cdpr.model import rotations
from cdpr.plugins.registry import registry
from cdpr.scenario import load_scenario
from cdpr.simulation.build import build, faults

EXACT = 1e-12  # m: round-off of lengths of some metres
STEP = 1e-6  # s, of central differences in time
WIDE = 1e-4  # m, of those of fourth order in space
GRADIENT = 1e-9  # their round-off is 1e-15 / WIDE, their error WIDE^4 times a fifth derivative

seeds = st.integers(0, 2**32 - 1)
FEW = settings(max_examples=min(EXAMPLES, 25))  # of eight cables each, searched for or differenced


def tangent(A, axis, radius, P):
    """Exit point and length by search: where the groove's tangent in the direction of travel passes through P."""
    axis = np.array(axis) / np.linalg.norm(axis)
    away = (P - A) - ((P - A) @ axis) * axis
    away /= np.linalg.norm(away)
    center = A + radius * away

    def at(angle):
        """Point on the groove, and direction of travel there: it begins at A along the axis."""
        arm = -np.cos(angle) * away + np.sin(angle) * axis
        return center + radius * arm, np.sin(angle) * away + np.cos(angle) * axis, arm

    def miss(angle):
        point, _, arm = at(angle)
        return (P - point) @ arm

    angles = np.linspace(0.0, 1.5 * np.pi, 200)
    for low, high in pairwise(angles):
        if miss(low) * miss(high) <= 0.0:
            angle = brentq(miss, low, high, xtol=1e-15)
            point, along, _ = at(angle)
            if (P - point) @ along > 0.0:
                return point, radius * angle + np.linalg.norm(P - point)
    raise AssertionError("no tangent")


def with_pulleys(robot, radius, axis=(0.0, 0.0, 1.0)):
    cables = tuple(replace(cable, exit=Pulley(radius=radius, axis=tuple(axis))) for cable in robot.cables)
    return replace(robot, cables=cables)


@FEW
@given(seeds, st.floats(0.01, 0.3))
def test_length_and_direction_are_those_of_the_tangent(seed, radius):
    rng = np.random.default_rng(seed)
    robot, state = make_robot(crossed_box(rng, 8)), random_state(rng)
    axis = rng.normal(size=3)
    robot = with_pulleys(robot, radius, axis)
    R = rotations.matrix(state[3:7])
    length, W = kinematics.lengths(robot, state), kinematics.wrench_matrix(robot, state)
    for i, cable in enumerate(robot.cables):
        P = state[:3] + R @ cable.platform
        E, whole = tangent(cable.frame, axis, radius, P)
        assert abs(length[i] - whole) <= EXACT
        u = (E - P) / np.linalg.norm(E - P)
        np.testing.assert_allclose(W[:3, i], u, rtol=0, atol=EXACT)
        np.testing.assert_allclose(W[3:, i], np.cross(R @ cable.platform, u), rtol=0, atol=EXACT)


@FEW
@given(seeds)
def test_the_length_changes_along_the_cable(seed):
    """Its gradient is -u, and the rate of the wrench matrix its derivative: the arc takes what the exit point gives."""
    rng = np.random.default_rng(seed)
    robot, state = with_pulleys(make_robot(crossed_box(rng, 8)), 0.1, rng.normal(size=3)), random_state(rng)
    W = kinematics.wrench_matrix(robot, state)
    for k in range(3):
        near, far = (
            kinematics.lengths(robot, state + wide * np.eye(13)[k])
            - kinematics.lengths(robot, state - wide * np.eye(13)[k])
            for wide in (WIDE, 2.0 * WIDE)
        )
        slope = (8.0 * near - far) / (12.0 * WIDE)
        np.testing.assert_allclose(slope, -W[k], rtol=0, atol=GRADIENT)
    before, after = moved(state, -STEP), moved(state, STEP)
    slope = (kinematics.lengths(robot, after) - kinematics.lengths(robot, before)) / (2.0 * STEP)
    np.testing.assert_allclose(kinematics.rates(robot, state), slope, atol=1e-8)
    slope = (kinematics.wrench_matrix(robot, after) - kinematics.wrench_matrix(robot, before)) / (2.0 * STEP)
    np.testing.assert_allclose(kinematics.wrench_matrix_rate(robot, state), slope, atol=1e-7)


@given(seeds)
def test_without_radius_it_is_the_point(seed):
    rng = np.random.default_rng(seed)
    robot, state = make_robot(crossed_box(rng, 8)), random_state(rng)
    small = with_pulleys(robot, 0.0, rng.normal(size=3))
    for of in (kinematics.lengths, kinematics.wrench_matrix, kinematics.rates, kinematics.wrench_matrix_rate):
        np.testing.assert_allclose(of(small, state), of(robot, state), rtol=0, atol=EXACT)


def test_the_quarter_turn_by_hand():
    """A cable that arrives upwards and leaves level, 2 m beyond the pulley's top."""
    robot = with_pulleys(make_robot(np.array([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])), 0.5)
    state = kinematics.make_state([2.5, 0.0, 1.5])
    assert kinematics.lengths(robot, state)[0] == pytest.approx(0.25 * np.pi + 2.0, abs=EXACT)
    np.testing.assert_allclose(kinematics.wrench_matrix(robot, state)[:3, 0], [-1.0, 0.0, 0.0], atol=EXACT)


def test_on_the_line_of_the_swivel_and_within_the_pulley():
    robot = with_pulleys(make_robot(np.array([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])), 0.5)
    assert kinematics.lengths(robot, kinematics.make_state([0.0, 0.0, 3.0]))[0] == pytest.approx(2.0, abs=EXACT)
    assert np.isfinite(kinematics.wrench_matrix(robot, kinematics.make_state([0.0, 0.0, -3.0]))).all()
    assert np.isnan(kinematics.lengths(robot, kinematics.make_state([0.5, 0.0, 1.1]))).all()


def test_no_cable_turns_by_more_than_three_quarters():
    """Positions below the pulley, on the line on which the cable arrives and nearer than the radius."""
    robot = with_pulleys(make_robot(np.array([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])), 0.5)
    for x, z, there in ((0.0, 0.2, True), (0.0, 0.9, False), (1e-3, 0.9, False), (2.0, 0.9, True)):
        length = kinematics.lengths(robot, kinematics.make_state([x, 0.0, z]))[0]
        assert np.isfinite(length) == there == (robot.cables[0].exit.obstacle([0, 0, 1], [x, 0.0, z]) == "")
        assert not length < 0.0


def test_cables_may_differ():
    rng = np.random.default_rng(1)
    robot, state = make_robot(crossed_box(rng, 8)), random_state(rng)
    cables = list(robot.cables)
    cables[2] = replace(cables[2], exit=Pulley(radius=0.1))
    cables[3] = replace(cables[3], exit=Point(type="point"))
    mixed = replace(robot, cables=tuple(cables))
    whole = with_pulleys(robot, 0.1)
    want = kinematics.lengths(robot, state)
    want[2] = kinematics.lengths(whole, state)[2]
    np.testing.assert_array_equal(kinematics.lengths(mixed, state), want)


@given(seeds)
def test_the_pose_comes_back_from_the_lengths(seed):
    rng = np.random.default_rng(seed)
    robot = with_pulleys(make_robot(crossed_box(rng, 8)), 0.1)
    state = random_state(rng, tilt=0.1)
    start = state[:7] + np.concatenate([rng.uniform(-0.05, 0.05, 3), np.zeros(4)])
    found = forward_kinematics(robot, kinematics.lengths(robot, state), start)
    assert found.converged
    np.testing.assert_allclose(found.pose[:3], state[:3], atol=1e-10)


@pytest.mark.parametrize("axis", [(0.0, 0.0, 0.0), (0.0, float("nan"), 1.0)])
def test_no_axis_no_pulley(axis):
    with pytest.raises(CdprError, match=r"^Pulley\(axis=\)"):
        Pulley(radius=0.1, axis=axis)


def test_a_pose_within_a_pulley_is_reported():
    robot = with_pulleys(make_robot(np.array([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])), 0.5)
    with pytest.raises(CdprError, match=r"has no length at .*, for its anchor on the platform lies within its pulley"):
        check_lengths(robot, np.array([0.5, 0.0, 1.1, 1.0, 0.0, 0.0, 0.0]))


def test_a_start_within_a_pulley_is_reported_at_its_key():
    changes = {"robot.cable.exit.radius": 1.0, "initial.position": [-7.6, -4.7, 5.0]}
    with pytest.raises(ScenarioError, match=r"initial.position: cable 'cable_1' has no length here: its anchor on the"):
        load_scenario(ROOT / "scenarios" / "cogiro_pulleys.yaml", overrides=changes)


@pytest.mark.parametrize(("backend", "cables"), [("mujoco", "native"), ("dart", "ups")])
def test_plants_with_cables_of_their_own_refuse_it(backend, cables):
    if registry().get("backend", backend).missing:
        pytest.skip(f"{backend} is not installed")
    changes = {f"backend_options.{backend}.cables": cables}
    scenario = load_scenario(ROOT / "scenarios" / "cogiro_pulleys.yaml", backend=backend, overrides=changes)
    with pytest.raises(PluginError, match=r"\.exit: backend .* does not support exits: pulley"):
        build(scenario)
    assert [fault.path for fault in faults(scenario)] == [("robot", "cable", "exit")]  # reported once
