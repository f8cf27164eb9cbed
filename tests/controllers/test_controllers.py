"""The control laws."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import GRAVITY, random_state
from hypothesis import given
from hypothesis import strategies as st

from cdpr.mechanics import dynamics, kinematics
from cdpr.model import rotations
from cdpr_controllers import ComputedTorqueOptions, StaticOptions
from cdpr_controllers.computed_torque import ComputedTorque
from cdpr_controllers.static import Static

pytestmark = pytest.mark.core

EXACT = 1e-10  # N, of wrenches of the order of 1e3

seeds = st.integers(0, 2**32 - 1)


def ask(controller, state, desired):
    wrench = np.full(6, np.nan)
    controller.control(0.0, state, desired, wrench)
    return wrench


def resting(state):
    return np.concatenate([state, np.zeros(6)])


@pytest.mark.parametrize(("kind", "options"), [(ComputedTorque, ComputedTorqueOptions), (Static, StaticOptions)])
def test_at_rest_on_target_it_carries_the_weight(offset_robot, kind, options):
    state = kinematics.make_state([0.1, 0.2, 1.5], rotations.from_rpy(0.2, -0.1, 0.4))
    wrench = ask(kind(offset_robot, GRAVITY, 1e-3, options()), state, resting(state))
    np.testing.assert_allclose(wrench, dynamics.required_wrench(offset_robot, state, GRAVITY), atol=EXACT)


@given(seeds)
def test_computed_torque_gives_the_error_its_linear_dynamics(offset_robot, seed):
    """The acceleration that results is a_d + kd e' + kp e, per degree of freedom, gyroscopic terms and all."""
    rng = np.random.default_rng(seed)
    state = random_state(rng)
    desired = np.concatenate([random_state(rng), rng.normal(size=6)])
    kp, kd = rng.uniform(0, 100, 6), rng.uniform(0, 20, 6)
    options = ComputedTorqueOptions(kp=tuple(kp), kd=tuple(kd))
    wrench = ask(ComputedTorque(offset_robot, GRAVITY, 1e-3, options), state, desired)
    turn = rotations.rotation_vector(rotations.multiply(desired[3:7], rotations.conjugate(state[3:7])))
    error = np.concatenate([desired[:3] - state[:3], turn])
    wanted = desired[13:] + kd * (desired[7:13] - state[7:]) + kp * error
    expected = dynamics.required_wrench(offset_robot, state, GRAVITY, wanted[:3], wanted[3:])
    np.testing.assert_allclose(wrench, expected, atol=1e-9)


@given(seeds)
def test_static_has_no_feed_forward(offset_robot, seed):
    rng = np.random.default_rng(seed)
    state, target = random_state(rng), random_state(rng)
    controller = Static(offset_robot, GRAVITY, 1e-3, StaticOptions(kp=0.0, kd=0.0))
    wrench = ask(controller, state, np.concatenate([target, rng.normal(size=6)]))
    still = np.concatenate([state[:7], np.zeros(6)])
    np.testing.assert_allclose(wrench, dynamics.required_wrench(offset_robot, still, GRAVITY), atol=EXACT)


@given(seeds)
def test_equal_gains_know_no_direction(offset_robot, seed):
    """Turning state, target and gravity turns the wrench."""
    rng = np.random.default_rng(seed)
    q = rotations.from_rpy(*rng.uniform(-3, 3, 3))
    R = rotations.matrix(q)

    def turned(values):
        values = values.copy()
        values[3:7] = rotations.multiply(q, values[3:7])
        for start in (0, *range(7, len(values), 3)):
            values[start : start + 3] = R @ values[start : start + 3]
        return values

    state, desired = random_state(rng), np.concatenate([random_state(rng), rng.normal(size=6)])
    for kind, options in ((ComputedTorque, ComputedTorqueOptions()), (Static, StaticOptions())):
        here = ask(kind(offset_robot, GRAVITY, 1e-3, options), state, desired)
        there = ask(kind(offset_robot, R @ GRAVITY, 1e-3, options), turned(state), turned(desired))
        np.testing.assert_allclose(there, np.concatenate([R @ here[:3], R @ here[3:]]), atol=1e-8)


def test_the_sign_of_a_quaternion_does_not_matter(offset_robot):
    rng = np.random.default_rng(1)
    state, desired = random_state(rng), np.concatenate([random_state(rng), rng.normal(size=6)])
    controller = ComputedTorque(offset_robot, GRAVITY, 1e-3, ComputedTorqueOptions())
    flipped = desired.copy()
    flipped[3:7] *= -1
    np.testing.assert_allclose(ask(controller, state, flipped), ask(controller, state, desired), rtol=1e-12)
