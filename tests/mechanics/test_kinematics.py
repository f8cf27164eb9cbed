"""Geometry of the cables against plain numpy and finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import crossed_box, make_robot, moved, random_state
from hypothesis import given
from hypothesis import strategies as st

from cdpr.mechanics import dynamics, kinematics
from cdpr.model import rotations

pytestmark = pytest.mark.core

EXACT = 1e-13  # roundings of a few products of order one
STEP = 1e-6  # for central differences: their error is about STEP^2, their noise 1e-16 / STEP
DIFFERENCE = 1e-8

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.integers(1, 12))
def test_wrench_matrix_and_lengths_by_definition(seed, m):
    rng = np.random.default_rng(seed)
    robot, state = make_robot(crossed_box(rng, m)), random_state(rng, tilt=2.0)
    R = rotations.matrix(state[3:7])
    vectors = robot.anchors[:, :3] - (state[:3] + robot.anchors[:, 3:] @ R.T)
    length = np.linalg.norm(vectors, axis=1)
    u = vectors / length[:, None]
    np.testing.assert_allclose(kinematics.lengths(robot, state), length, rtol=EXACT)
    W = kinematics.wrench_matrix(robot, state)
    np.testing.assert_allclose(W, np.vstack([u.T, np.cross(robot.anchors[:, 3:] @ R.T, u).T]), atol=EXACT)
    np.testing.assert_allclose(kinematics.rates(robot, state), -W.T @ state[7:], atol=1e-12)


@given(seeds)
def test_rates_and_matrix_rate_are_derivatives(seed):
    rng = np.random.default_rng(seed)
    robot, state = make_robot(crossed_box(rng, 8)), random_state(rng)
    before, after = moved(state, -STEP), moved(state, STEP)
    slope = (kinematics.lengths(robot, after) - kinematics.lengths(robot, before)) / (2 * STEP)
    np.testing.assert_allclose(kinematics.rates(robot, state), slope, atol=DIFFERENCE)
    slope = (kinematics.wrench_matrix(robot, after) - kinematics.wrench_matrix(robot, before)) / (2 * STEP)
    np.testing.assert_allclose(kinematics.wrench_matrix_rate(robot, state), slope, atol=DIFFERENCE)


def test_a_positive_tension_pulls_towards_the_frame():
    robot = make_robot(np.array([[0.0, 0.0, 4.0, 0.0, 0.0, 0.5]]))
    W = kinematics.wrench_matrix(robot, kinematics.make_state([0, 0, 1]))
    np.testing.assert_array_equal(W[:, 0], [0, 0, 1, 0, 0, 0])
    assert kinematics.rates(robot, kinematics.make_state([0, 0, 1], velocity=[0, 0, 2]))[0] == -2.0


@given(seeds)
def test_required_wrench_is_newton_and_euler(offset_robot, seed):
    """The rate of momentum and of angular momentum about the centre of mass, by finite differences."""
    rng = np.random.default_rng(seed)
    state = random_state(rng, tilt=1.0)
    a, alpha, g = rng.normal(size=3), rng.normal(size=3), np.array([0.3, -0.2, -9.81])
    platform = offset_robot.platform

    def momenta(dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        later = moved(np.concatenate([state[:10], state[10:] + 0.5 * dt * alpha]), dt)
        R = rotations.matrix(later[3:7])
        omega = state[10:] + dt * alpha
        r = R @ platform.center_of_mass
        p = platform.mass * (state[7:10] + dt * a + np.cross(omega, r))
        return p, R @ platform.inertia @ R.T @ omega, r

    (p0, L0, _), (p1, L1, _), (_, _, r) = momenta(-STEP), momenta(STEP), momenta(0.0)
    force = (p1 - p0) / (2 * STEP) - platform.mass * g
    moment = (L1 - L0) / (2 * STEP) + np.cross(r, force)
    got = dynamics.required_wrench(offset_robot, state, g, a, alpha)
    np.testing.assert_allclose(got, np.concatenate([force, moment]), atol=1e-6)


def test_statics_carries_the_weight_at_its_lever(offset_robot):
    wrench = dynamics.required_wrench(offset_robot, kinematics.make_state([0, 0, 1]), [0, 0, -10.0])
    np.testing.assert_allclose(wrench, [0, 0, 500, -0.03 * 500, -0.05 * 500, 0], atol=1e-12)


def test_characteristic_length():
    robot = make_robot(np.array([[0, 0, 4, 3, 0, 0], [0, 1, 4, 0, 4, 0.0]]))
    assert robot.characteristic_length == np.sqrt(12.5)
    assert make_robot(np.array([[0, 0, 4, 0, 0, 0.0]])).characteristic_length == 1.0
