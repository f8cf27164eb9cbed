"""The desired motion: boundary values, derivatives, continuity."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdpr.model import rotations
from cdpr.trajectory import Knot, hold, through

pytestmark = pytest.mark.core

BOUNDARY = 1e-9  # quintic coefficients of order 100, a solve for the attitude
STEP = 1e-5
DIFFERENCE = 1e-5  # third derivatives of order 1e3 times STEP^2, noise 1e-16 / STEP^2 for angular acceleration

seeds = st.integers(0, 2**32 - 1)


def random_knot(rng: np.random.Generator, time: float, *, free: bool = False) -> Knot:
    rates = [None] * 4 if free else list(rng.uniform(-1, 1, (4, 3)))
    velocity, angular_velocity, acceleration, angular_acceleration = rates
    return Knot(
        time,
        rng.uniform(-1, 1, 3),
        rotations.from_rpy(*rng.uniform(-0.7, 0.7, 3)),
        velocity,
        angular_velocity,
        acceleration,
        angular_acceleration,
    )


def assert_sample(trajectory, time, knot):
    got = trajectory.sample(time)
    np.testing.assert_allclose(got[:3], knot.position, atol=BOUNDARY)
    np.testing.assert_allclose(rotations.matrix(got[3:7]), rotations.matrix(knot.orientation), atol=BOUNDARY)
    for columns, value in (
        (slice(7, 10), knot.velocity),
        (slice(10, 13), knot.angular_velocity),
        (slice(13, 16), knot.acceleration),
        (slice(16, 19), knot.angular_acceleration),
    ):
        if value is not None:
            np.testing.assert_allclose(got[columns], value, atol=BOUNDARY)


def assert_consistent(trajectory, time):
    """Velocities and accelerations are the derivatives of the pose."""
    before, here, after = (trajectory.sample(time + dt) for dt in (-STEP, 0.0, STEP))
    np.testing.assert_allclose((after[:3] - before[:3]) / (2 * STEP), here[7:10], atol=DIFFERENCE)
    np.testing.assert_allclose((after[7:10] - before[7:10]) / (2 * STEP), here[13:16], atol=DIFFERENCE)
    turn = rotations.rotation_vector(rotations.multiply(after[3:7], rotations.conjugate(before[3:7])))
    np.testing.assert_allclose(turn / (2 * STEP), here[10:13], atol=DIFFERENCE)
    np.testing.assert_allclose((after[10:13] - before[10:13]) / (2 * STEP), here[16:19], atol=DIFFERENCE)


@given(seeds)
def test_quintic_meets_any_boundary_values(seed):
    rng = np.random.default_rng(seed)
    start, end = random_knot(rng, 0.5), random_knot(rng, 2.3)
    trajectory = through([start, end])
    assert (trajectory.start, trajectory.end) == (0.5, pytest.approx(2.3))
    assert_sample(trajectory, 0.5, start)
    assert_sample(trajectory, 2.3, end)
    for time in rng.uniform(0.6, 2.2, 3):
        assert_consistent(trajectory, time)


@given(seeds)
def test_at_rest_it_takes_the_shortest_rotation(seed):
    rng = np.random.default_rng(seed)
    q0, q1 = rotations.from_rpy(*rng.uniform(-3, 3, 3)), rotations.from_rpy(*rng.uniform(-3, 3, 3))
    trajectory = through([Knot(0.0, np.zeros(3), q0), Knot(2.0, np.ones(3), q1)])
    turn = rotations.rotation_vector(rotations.multiply(q1, rotations.conjugate(q0)))
    angle = np.linalg.norm(turn)
    for time in (0.3, 1.0, 1.7):
        s = time / 2
        share = s**3 * (10 - 15 * s + 6 * s**2)
        got = trajectory.sample(time)
        done = rotations.rotation_vector(rotations.multiply(got[3:7], rotations.conjugate(q0)))
        np.testing.assert_allclose(done, share * turn, atol=1e-9)
        assert np.linalg.norm(np.cross(got[10:13], turn)) <= 1e-9 * angle
        np.testing.assert_allclose(got[:3], share, atol=1e-12)


@given(seeds)
def test_waypoints_are_met_with_continuous_acceleration(seed):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.3, 1.5, 5))
    knots = [random_knot(rng, time, free=rng.random() < 0.7) for time in times]
    trajectory = through(knots)
    for knot in knots:
        assert_sample(trajectory, knot.time, knot)
    for time in times[1:-1]:
        before, after = trajectory.sample(time - 1e-9), trajectory.sample(time + 1e-9)
        np.testing.assert_allclose(before, after, atol=1e-5)
        assert_consistent(trajectory, time + 0.1)


def test_free_knots_give_the_single_quintic():
    """A knot on the least-jerk curve between two others changes nothing."""
    q = rotations.from_rpy(0.1, 0.2, 0.3)
    ends = [Knot(0.0, np.zeros(3), q), Knot(2.0, np.ones(3), rotations.from_rpy(0.1, 0.2, 0.9))]
    single = through(ends)
    at = single.sample(0.7)
    split = through([ends[0], Knot(0.7, at[:3], at[3:7]), ends[1]])
    for time in (0.2, 0.7, 1.3):
        np.testing.assert_allclose(split.sample(time), single.sample(time), atol=1e-9)


def test_rest_before_and_after():
    trajectory = through([Knot(1.0, np.zeros(3), [1, 0, 0, 0]), Knot(2.0, np.ones(3), [1, 0, 0, 0])])
    np.testing.assert_array_equal(trajectory.sample(0.0)[:3], 0.0)
    np.testing.assert_allclose(trajectory.sample(5.0)[:3], 1.0, rtol=1e-14)
    np.testing.assert_array_equal(trajectory.sample(0.5)[7:], 0.0)
    np.testing.assert_array_equal(trajectory.sample(5.0)[7:], 0.0)


def test_hold():
    q = rotations.from_rpy(0.3, 0.1, -0.2)
    sample = hold(np.array([1.0, 2.0, 3.0]), q).sample(17.0)
    np.testing.assert_allclose(sample, [1, 2, 3, *q, *[0] * 12], atol=1e-15)


def test_times_must_increase():
    knot = Knot(0.0, np.zeros(3), np.array([1.0, 0, 0, 0]))
    with pytest.raises(ValueError, match="increasing"):
        through([knot, knot])
    with pytest.raises(ValueError, match="two or more"):
        through([knot])


def test_the_quaternion_does_not_jump_at_a_knot():
    """q and -q are one attitude."""
    q = rotations.from_rpy(0.1, 0.2, 0.3)
    knots = [Knot(float(k), np.full(3, float(k)), (-1) ** k * q) for k in range(4)]
    trajectory = through(knots)
    path = np.array([trajectory.sample(time)[3:7] for time in np.linspace(0, 3, 301)])
    assert np.abs(np.diff(path, axis=0)).max() < 1e-12
