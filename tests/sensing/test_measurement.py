"""Errors, rate, delay, jitter and losses of measurements, against numpy and statistics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal, stats
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.native.random_numbers import Stream, normal_numbers, uniform_numbers
from cdpr.sensing import Encoders, Imu, Pose, Receiver, Scan, Tension
from cdpr.sensing.measurement import measurements

STEP = 0.001  # s
SIGMAS = 4.0  # bound of a statistic: exceeded by chance in one of 16 000 cases, and the seed is fixed


def still(count, width=3):
    return np.zeros((count, width))


def errors_of(count, *, seed=0, **errors):
    return measurements(Receiver(position=errors), still(count), STEP, seed)[0]


@pytest.mark.parametrize("count", [20_000, pytest.param(1_000_000, marks=pytest.mark.slow)])
def test_noise_is_white_and_normal(count):
    values = errors_of(count, noise=0.02, bias=(0.1, 0.2, -0.3))
    noise = (values - [0.1, 0.2, -0.3]) / 0.02
    assert np.abs(noise.mean(axis=0)).max() < SIGMAS / np.sqrt(count)
    assert np.abs(noise.var(axis=0) - 1.0).max() < SIGMAS * np.sqrt(2.0 / count)
    for column in noise.T:
        for lag in (1, 2, 10, 100):
            assert abs(np.mean(column[lag:] * column[:-lag])) < SIGMAS / np.sqrt(count - lag)
        assert stats.kstest(column, "norm").pvalue > 1e-4
    assert np.abs(np.corrcoef(noise.T) - np.eye(3)).max() < SIGMAS / np.sqrt(count)
    _, power = signal.periodogram(noise[:, 0])
    bands = power[1 : 1 + (len(power) - 1) // 10 * 10].reshape(10, -1)  # each value has an exponential distribution
    assert np.abs(bands.mean(axis=1) / 2.0 - 1.0).max() < SIGMAS / np.sqrt(bands.shape[1])


@pytest.mark.parametrize("count", [20_000, pytest.param(1_000_000, marks=pytest.mark.slow)])
def test_drift_is_a_random_walk(count):
    drift = errors_of(count, drift=0.5)
    assert np.array_equal(drift[0], np.zeros(3))
    steps = np.diff(drift, axis=0) / (0.5 * np.sqrt(STEP))
    assert np.abs(steps.mean(axis=0)).max() < SIGMAS / np.sqrt(count)
    assert np.abs(steps.var(axis=0) - 1.0).max() < SIGMAS * np.sqrt(2.0 / count)
    assert np.abs(np.mean(steps[1:] * steps[:-1], axis=0)).max() < SIGMAS / np.sqrt(count)


def test_gain_bias_and_resolution_act_in_this_order():
    truth = np.linspace(-3.0, 3.0, 301)[:, None] * np.ones(3)
    sensor = Receiver(position={"gain": 1.1, "bias": 0.25, "resolution": 0.125})
    measured, _ = measurements(sensor, truth, STEP)
    assert np.array_equal(measured, 0.125 * np.rint((1.1 * truth + 0.25) / 0.125))


def test_rays_without_an_obstacle_have_no_errors():
    """Else half of them would end at an obstacle just within reach. Other rays have the same noise."""
    truth = np.tile([2.0, 4.0, 3.0], (200, 1))
    errors = {"noise": 0.1, "bias": -0.3, "gain": 1.01, "drift": 1.0}
    near, far = (measurements(Scan(rays=3, reach=reach, distance=errors), truth, STEP)[0] for reach in (4.0, 5.0))
    assert np.array_equal(near[:, 1], truth[:, 1])
    assert np.array_equal(near[:, [0, 2]], far[:, [0, 2]])
    assert np.abs(far[:, 1] - 4.0).min() > 0.0


def test_the_noise_is_the_stream_of_seed_and_name():
    values = errors_of(40, seed=7, noise=2.0)
    assert values.tobytes() == (2.0 * normal_numbers(Stream(7, "sensors.receiver").state, 120)).reshape(-1, 3).tobytes()
    named = measurements(Receiver(name="gps", position={"noise": 2.0}), still(40), STEP, 7)[0]
    assert not np.isin(named, values).any()


def test_attitudes_turn_about_axes_of_the_platform():
    turns = Rotation.from_rotvec(np.random.default_rng(1).normal(size=(50, 3)))
    truth = np.hstack([np.zeros((50, 3)), turns.as_quat(scalar_first=True)])
    bias = (0.01, -0.02, 0.03)
    measured, _ = measurements(Pose(attitude={"bias": bias}), truth, STEP)
    error = turns.inv() * Rotation.from_quat(measured[:, 3:], scalar_first=True)
    assert np.abs(error.as_rotvec() - bias).max() < 1e-14  # round-off of two quaternion products


def test_without_errors_values_have_the_bits_of_the_truth():
    truth = np.random.default_rng(2).normal(size=(30, 7))
    truth[3, :3] = -0.0
    measured, age = measurements(Pose(), truth, STEP)
    assert measured.tobytes() == truth.tobytes()
    assert not age.any()


def test_rates_are_differences_over_the_period():
    lengths = np.random.default_rng(3).normal(size=(41, 2))
    truth = np.hstack([lengths, np.full((41, 2), 5.0)])
    measured, _ = measurements(Encoders(period=4 * STEP, length={"bias": 0.5}), truth, STEP)
    taken = lengths[::4] + 0.5
    assert np.array_equal(measured[::4, :2], taken)
    assert np.array_equal(measured[8::4, 2:], np.diff(taken, axis=0)[1:] / (4 * STEP))
    assert np.array_equal(measured[:8, 2:], np.full((8, 2), 5.0))


def replay(count, every, delay, jitter, dropout, stream):
    """Index of the measurement that is held at each control step, and its age in steps, from the stream of uniforms."""
    arrivals, held, ages, last = [], [], [], 0
    current = 0
    for k in range(count):
        if k % every == 0:
            lost = dropout > 0.0 and uniform_numbers(stream, 1)[0] < dropout
            late = int(uniform_numbers(stream, 1)[0] * (jitter + 1)) if jitter else 0
            if k == 0:
                arrivals.append((0, 0))
            elif not lost:
                last = max(last, k + delay + late)
                arrivals.append((last, k))
        while arrivals and arrivals[0][0] <= k:
            current = arrivals.pop(0)[1]
        held.append(current)
        ages.append(k - current)
    return held, ages


@settings(deadline=None)
@given(st.integers(1, 7), st.integers(0, 20), st.integers(0, 9), st.sampled_from([0.0, 0.2, 0.9]), st.integers(0, 1000))
def test_arrivals_are_those_of_a_replay(every, delay, jitter, dropout, seed):
    count = 80
    truth = np.arange(float(count))[:, None] * np.ones(3)
    sensor = Receiver(period=every * STEP, delay=delay * STEP, jitter=jitter * STEP, dropout=dropout)
    measured, age = measurements(sensor, truth, STEP, seed)
    held, ages = replay(count, every, delay, jitter, dropout, Stream(seed, "sensors.receiver").state)
    assert measured[:, 0].tolist() == held
    assert np.array_equal(age, np.array(ages) * STEP)


def test_a_delay_is_exact_to_one_step():
    truth = np.arange(100.0)[:, None] * np.ones(3)
    measured, age = measurements(Receiver(delay=10 * STEP), truth, STEP)
    assert np.array_equal(measured[10:], truth[:-10])
    assert np.array_equal(measured[:10], np.zeros((10, 3)))
    assert np.array_equal(age[10:], np.full(90, 10 * STEP))


def test_the_width_of_true_values_is_checked():
    assert measurements(Tension(), np.ones((3, 5)), STEP)[0].shape == (3, 5)
    for sensor, shape in (Imu(), (5, 5)), (Encoders(), (5, 3)), (Receiver(), (3,)), (Tension(), (4, 0)):
        with pytest.raises(cdpr.CdprError, match="truth: expected an array"):
            measurements(sensor, np.ones(shape), STEP)
