"""Arch, circle, helix and stop-to-stop moves: their form, their derivatives, their limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motion_cases import UPRIGHT, assert_smooth, samples
from scipy.spatial.transform import Rotation
from test_trajectory import assert_consistent

from cdpr.model import rotations
from cdpr.trajectory import Limits, Stop, arch, circle, stop_to_stop
from cdpr.trajectory.jerk_limited import fastest

seeds = st.integers(0, 2**32 - 1)


def quintic(s):
    return s**3 * (10 - 15 * s + 6 * s**2)


# Pick and place


@given(seeds)
def test_an_arch(seed):
    rng = np.random.default_rng(seed)
    p0, p1 = rng.uniform(-1, 1, (2, 3))
    q0, q1 = (rotations.from_rpy(*rng.uniform(-1, 1, 3)) for _ in range(2))
    height, vertical, start, duration = rng.uniform(0, 1), rng.choice([0.0, rng.uniform(0, 0.45)]), 0.5, 3.0
    motion = arch(start, duration, (p0, p1), (q0, q1), height, vertical)
    assert (motion.start, motion.end) == (start, pytest.approx(start + duration))
    assert_smooth(motion)
    times, rows = samples(motion, 401)
    share = (times - start) / duration
    across = quintic(np.clip((share - vertical) / (1 - 2 * vertical), 0, 1))
    np.testing.assert_allclose(rows[:, :2], p0[:2] + across[:, None] * (p1 - p0)[:2], atol=1e-12)
    top = max(p0[2], p1[2]) + height
    rise, sink = quintic(np.clip(2 * share, 0, 1)), quintic(np.clip(2 * share - 1, 0, 1))
    np.testing.assert_allclose(rows[:, 2], p0[2] + (top - p0[2]) * rise + (p1[2] - top) * sink, atol=1e-12)
    assert rows[:, 2].max() == pytest.approx(top, abs=1e-12)
    turn = rotations.rotation_vector(rotations.multiply(rotations.conjugate(q0), q1))
    expected = (Rotation.from_quat(q0, scalar_first=True) * Rotation.from_rotvec(across[:, None] * turn)).as_matrix()
    np.testing.assert_allclose([rotations.matrix(q) for q in rows[:, 3:7]], expected, atol=1e-12)
    for time in rng.uniform(start + 0.01, start + duration - 0.01, 3):
        assert_consistent(motion, time)


# Circle and helix


def true_circle(times, start, duration, position, center, normal, turns, pitch):
    """Position, velocity and acceleration by rotating the arm."""
    s = (times - start) / duration
    full = 2 * np.pi * turns
    angle = full * quintic(s)
    rate = full * 30 * (s * (1 - s)) ** 2 / duration
    second = full * 60 * s * (1 - s) * (1 - 2 * s) / duration**2
    arms = Rotation.from_rotvec(angle[:, None] * normal).apply(position - center)
    climb = pitch / (2 * np.pi) * normal
    tangent = np.cross(normal, arms)
    inwards = np.cross(normal, tangent)
    x = center + arms + angle[:, None] * climb
    v = rate[:, None] * (tangent + climb)
    a = second[:, None] * (tangent + climb) + (rate**2)[:, None] * inwards
    return angle, x, v, a


@pytest.mark.parametrize("turns", [0.01, -0.25, 1.0, -3.0, 40.0])
@pytest.mark.parametrize("radius", [0.01, 1.0, 10.0])
@pytest.mark.usual("10.0-*", "0.01--3.0")
def test_a_helix_is_met_within_the_stated_error(turns, radius):
    rng = np.random.default_rng(3)
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    center = rng.uniform(-1, 1, 3)
    arm = np.cross(normal, rng.normal(size=3))
    position = center + radius * arm / np.linalg.norm(arm)
    orientation = rotations.from_rpy(0.2, -0.3, 0.5)
    start, duration, pitch = 0.5, 4.0 * max(abs(turns), 1.0), 0.3
    motion = circle(start, duration, position, orientation, center, normal, turns, pitch=pitch, turning=True)
    times, rows = samples(motion, 7919)
    angle, x, v, a = true_circle(times, start, duration, position, center, normal, turns, pitch)
    # The bound, and the rounding of coordinates.
    assert np.linalg.norm(rows[:, :3] - x, axis=1).max() < 1e-11 * radius + 3e-14
    assert np.linalg.norm(rows[:-1, 7:10] - v[:-1], axis=1).max() < 2e-9 * radius + 1e-12
    assert np.linalg.norm(rows[:-1, 13:16] - a[:-1], axis=1).max() < 4e-7 * radius + 1e-9
    R = (Rotation.from_rotvec(angle[:, None] * normal) * Rotation.from_quat(orientation, scalar_first=True)).as_matrix()
    np.testing.assert_allclose([rotations.matrix(q) for q in rows[:, 3:7]], R, atol=1e-11)
    np.testing.assert_allclose(rows[:, 10:13], (v @ normal / pitch * 2 * np.pi)[:, None] * normal, atol=1e-9)
    assert_smooth(motion)
    for time in start + duration * np.array([0.1, 0.313, 0.8]):
        assert_consistent(motion, time) if radius <= 1 else None


def test_a_circle_without_turning_keeps_its_attitude():
    q = rotations.from_rpy(0.1, 0.2, 0.3)
    motion = circle(0.0, 5.0, np.array([1.0, 0, 2]), q, np.array([0, 0, 2.0]), np.array([0, 0, 1.0]), 1.0)
    _, rows = samples(motion)
    np.testing.assert_allclose(rows[:, 3:7], np.tile(q, (len(rows), 1)), atol=1e-15)
    np.testing.assert_array_equal(rows[:, 10:13], 0.0)
    np.testing.assert_allclose(np.linalg.norm(rows[:, :2], axis=1), 1.0, atol=1e-11)
    np.testing.assert_array_equal(rows[:, 2], 2.0)
    np.testing.assert_allclose(motion.sample(2.5)[:3], [-1, 0, 2], atol=1e-11)
    assert motion.sample(1.0)[1] > 0  # right-handed about the normal
    assert len(motion.segments) < 250


# Stop to stop


LIMITS = Limits(0.8, 1.5, 10.0)
ANGULAR = Limits(0.6, 2.0, 15.0)


def test_stops_are_reached_and_limits_respected():
    rng = np.random.default_rng(1)
    stops = [
        Stop(rng.uniform(-1, 1, 3), rotations.from_rpy(*rng.uniform(-1, 1, 3)), pause) for pause in (0.1, 0, 0.3, 0, 0)
    ]
    stops.insert(2, Stop(stops[1].position, stops[1].orientation))  # no move at all
    stops.insert(4, Stop(stops[3].position, rotations.from_rpy(0.3, 0, 1)))  # turns in place
    motion = stop_to_stop(0.5, stops, LIMITS, ANGULAR)
    assert_smooth(motion)
    times, rows = samples(motion, 20001)
    step = times[1] - times[0]
    for columns, limits in ((slice(0, 3), LIMITS), (slice(3, 6), ANGULAR)):
        speed = np.linalg.norm(rows[:, 7:13][:, columns], axis=1)
        pull = np.linalg.norm(rows[:, 13:19][:, columns], axis=1)
        jerk = np.linalg.norm(np.diff(rows[:, 13:19][:, columns], axis=0), axis=1) / step
        for value, limit in ((speed, limits.velocity), (pull, limits.acceleration), (jerk, limits.jerk)):
            assert value.max() <= limit * (1 + 1e-6)
            assert value.max() >= 0.99 * limit  # some move reaches it
    resting = rows[np.abs(rows[:, 7:13]).max(axis=1) < 1e-4]
    for stop in stops:
        assert np.linalg.norm(resting[:, :3] - stop.position, axis=1).min() < 1e-6
    np.testing.assert_allclose(rows[-1, :3], stops[-1].position, atol=1e-14)
    np.testing.assert_allclose(rotations.matrix(rows[-1, 3:7]), rotations.matrix(stops[-1].orientation), atol=1e-13)
    for time in rng.uniform(0.6, motion.end, 20):
        if np.abs(motion.segments[:, 0] - time).min() > 1e-4:  # jerk is not continuous
            assert_consistent(motion, time)


@given(*[st.floats(-6, 6).map(lambda x: 10**x)] * 3)
def test_the_phases_lead_from_0_to_1(velocity, acceleration, jerk):
    s = v = a = 0.0
    peak = [0.0, 0.0]
    for duration, j in fastest(Limits(velocity, acceleration, jerk)):
        assert duration >= 0
        s += v * duration + a * duration**2 / 2 + j * duration**3 / 6
        v += a * duration + j * duration**2 / 2
        a += j * duration
        peak = [max(peak[0], abs(v)), max(peak[1], abs(a))]
    assert s == pytest.approx(1.0, rel=1e-9)
    assert abs(v) < 1e-9 * peak[0]
    assert abs(a) < 1e-9 * peak[1]
    assert peak[0] <= velocity * (1 + 1e-12)
    assert peak[1] <= acceleration * (1 + 1e-12)


@given(*[st.floats(-2, 2).map(lambda x: 10**x)] * 3)
def test_no_motion_within_the_limits_is_faster(velocity, acceleration, jerk):
    ruckig = pytest.importorskip("ruckig")
    task = ruckig.InputParameter(1)
    task.target_position = [1.0]
    task.max_velocity, task.max_acceleration, task.max_jerk = [velocity], [acceleration], [jerk]
    found = ruckig.Trajectory(1)
    assert ruckig.Ruckig(1).calculate(task, found) == ruckig.Result.Working
    ours = sum(duration for duration, _ in fastest(Limits(velocity, acceleration, jerk)))
    assert ours == pytest.approx(found.duration, rel=1e-9)


def test_a_turn_needs_limits_and_no_move_is_a_hold():
    turned = rotations.from_rpy(0, 0, 1)
    with pytest.raises(ValueError, match="needs limits of its rotation"):
        stop_to_stop(0.0, [Stop(np.zeros(3), UPRIGHT), Stop(np.ones(3), turned)], LIMITS, None)
    still = stop_to_stop(0.0, [Stop(np.ones(3), turned), Stop(np.ones(3), turned)], LIMITS, None)
    np.testing.assert_allclose(still.sample(3.0)[:7], [1, 1, 1, *turned])
    paused = stop_to_stop(0.0, [Stop(np.ones(3), turned, 2.0)], LIMITS, None)
    assert paused.end == 2.0
