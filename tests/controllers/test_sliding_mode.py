"""The controller `sliding_mode`: its law, its reaching phase and its bounds under disturbances."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import GRAVITY, ROOT, random_state
from plants import installed
from restarts import assert_restarts_give

import cdpr
from cdpr.mechanics import dynamics
from cdpr.model import rotations
from cdpr_controllers import ComputedTorqueOptions, SlidingModeOptions
from cdpr_controllers.computed_torque import ComputedTorque
from cdpr_controllers.sliding_mode import SlidingMode

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
EXACT = 1e-9  # N, of wrenches of the order of 1e3
SLOPE, GAIN, LAYER = 8.0, 3.0, 0.05
LAW = {"type": "sliding_mode", "slope": SLOPE, "gain": GAIN, "layer": LAYER}
MASS, SHARE = 150.0, 0.6  # kg; of the gain, acceleration of the disturbances
HELD = 1.03  # bounds are exceeded by a few per cent of what changes in a control step, gain / layer * step = 0.06


def ask(controller, state, desired):
    wrench = np.full(6, np.nan)
    controller.control(0.0, state, desired, wrench)
    return wrench


def turned(vector):
    return rotations.from_axis_angle(vector / np.linalg.norm(vector), float(np.linalg.norm(vector)))


@pytest.mark.parametrize("scale", [1e-3, 1.0])
def test_the_law(offset_robot, scale):
    """Inside the boundary layers and outside."""
    rng = np.random.default_rng(3)
    options = SlidingModeOptions(slope=(7.0, 3.0), gain=(2.0, 5.0), layer=(0.1, 0.4))
    controller = SlidingMode(offset_robot, GRAVITY, 1e-3, options)
    sliding = {"sliding_velocity": np.zeros(3), "sliding_turn_rate": np.zeros(3)}
    controller.log(sliding)
    for _ in range(20):
        state = random_state(rng)
        error = scale * rng.uniform(0.1, 0.3, 12)
        desired = np.concatenate([state, rng.normal(size=6)])
        desired[:3] += error[:3]
        desired[3:7] = rotations.multiply(turned(error[3:6]), state[3:7])
        desired[7:13] += error[6:]
        wanted = desired[13:].copy()
        for at, slope, gain, layer in ((0, 7.0, 2.0, 0.1), (3, 3.0, 5.0, 0.4)):
            e, rate = error[at : at + 3], error[6 + at : 9 + at]
            s = rate + slope * e
            wanted[at : at + 3] += slope * rate + gain * s / max(np.linalg.norm(s), layer)
            assert (np.linalg.norm(s) < layer) == (scale < 1.0)
        wrench = ask(controller, state, desired)
        expected = dynamics.required_wrench(offset_robot, state, GRAVITY, wanted[:3], wanted[3:])
        np.testing.assert_allclose(wrench, expected, atol=EXACT)
        np.testing.assert_allclose(sliding["sliding_velocity"], error[6:9] + 7.0 * error[:3], atol=1e-12)
        np.testing.assert_allclose(sliding["sliding_turn_rate"], error[9:] + 3.0 * error[3:6], atol=1e-12)


def test_in_the_layer_it_is_computed_torque(offset_robot):
    rng = np.random.default_rng(4)
    state = random_state(rng)
    desired = np.concatenate([state, rng.normal(size=6)])
    desired[:3] += 0.005
    thick = SlidingMode(offset_robot, GRAVITY, 1e-3, SlidingModeOptions(slope=10.0, gain=2.0, layer=0.2))
    plain = ComputedTorque(offset_robot, GRAVITY, 1e-3, ComputedTorqueOptions(kp=100.0, kd=20.0))
    np.testing.assert_allclose(ask(thick, state, desired), ask(plain, state, desired), atol=EXACT)


def disturbed(controller, **changes):
    """CAROCA starts 0.1 m beside its pose, and a rotating force pushes it."""
    push = SHARE * GAIN * MASS
    events = [
        {"type": "sine", "time": 0.0, "force": [push, 0.0, 0.0], "frequency": 0.4},
        {"type": "sine", "time": 0.0, "force": [0.0, push, 0.0], "frequency": 0.4, "phase": np.pi / 2},
    ]
    held = {"trajectory": {"type": "hold", "position": [0.0, 0.1, 1.2]}, "simulation.duration": 4.0, "events": events}
    return cdpr.simulate(CAROCA, overrides={**held, "controller": controller, **changes})


def test_it_reaches_the_layer_in_time_and_stays_within_its_bounds():
    run = disturbed(LAW)
    push = np.linalg.norm(run.external[:, :3], axis=1) / MASS
    assert push.max() == pytest.approx(SHARE * GAIN, rel=1e-6)
    s, error = np.linalg.norm(run["sliding_velocity"], axis=1), np.linalg.norm(run.position_error, axis=1)
    assert s[0] == pytest.approx(SLOPE * 0.1, rel=1e-9)
    rest = LAYER * SHARE  # m/s: bound of s
    reaching = np.maximum(s[0] - (1.0 - SHARE) * GAIN * run.time, rest)
    first = int(np.argmax(s <= LAYER))  # then it only decays towards its bound
    assert 0 < run.time[first] <= (s[0] - LAYER) / ((1.0 - SHARE) * GAIN)
    assert (s[:first] <= HELD * reaching[:first]).all()
    late = run.time > run.time[first] + 5.0 * LAYER / GAIN + 5.0 / SLOPE
    assert s[late].max() <= HELD * rest
    assert error[late].max() <= HELD * rest / SLOPE
    assert error[late].max() > 0.5 * rest / SLOPE  # the bound is not idle


def test_a_gain_below_the_disturbance_does_not_hold():
    run = disturbed(LAW | {"gain": 0.5 * SHARE * GAIN})
    late = run.time > 2.0
    assert np.linalg.norm(run.position_error, axis=1)[late].max() > 10.0 * LAYER / SLOPE


def test_the_error_under_a_wrong_mass_is_bounded():
    """A mass believed 15 % too small disturbs by the same share of gravity and acceleration, over 0.85."""
    run = cdpr.simulate(CAROCA, overrides={"controller": LAW, "believed": {"platform": {"mass": 0.85 * MASS}}})
    disturbance = (1.0 / 0.85 - 1.0) * np.linalg.norm(run.desired_acceleration - GRAVITY, axis=1).max()
    assert disturbance < GAIN
    error = np.linalg.norm(run.position_error, axis=1)
    assert error[-1] == pytest.approx(0.15 * 9.81 / 0.85 / (SLOPE * GAIN / LAYER), rel=1e-3)
    assert error.max() <= HELD * disturbance / (SLOPE * GAIN / LAYER)


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
def test_snapshots_resets_and_rollouts_have_the_same_bits(backend):
    overrides = {"simulation.duration": 0.05, "controller.type": "sliding_mode", "initial.position": [0.0, 0.2, 1.2]}
    overrides |= {"simulation.backend": backend}
    whole = cdpr.simulate(CAROCA, overrides=overrides)
    assert whole.interpreted == ()
    assert_restarts_give(whole.rows.tobytes(), CAROCA, overrides)
    columns = ["position", "wrench", "sliding_velocity"]
    batch = cdpr.rollout(
        CAROCA, 9, vary={"controller.gain": [2.0 + k for k in range(9)]}, overrides=overrides, columns=columns
    )
    for i in (0, 8):
        single = cdpr.simulate(CAROCA, overrides={**overrides, "controller.gain": 2.0 + i})
        assert all(batch[name][i].tobytes() == np.ascontiguousarray(single[name]).tobytes() for name in columns)
