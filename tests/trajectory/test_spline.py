"""The minimum-jerk spline: against a dense solution, and large tables."""

from __future__ import annotations

import numpy as np
import pytest
from counted import calls
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

from cdpr.model import rotations
from cdpr.trajectory import interpolate
from cdpr.trajectory.spline import _COST, minimum_jerk


def dense(times, x, v, a):
    """The same minimum from one full system in all unknowns of one coordinate."""
    cost = np.zeros((3 * len(times), 3 * len(times)))
    for k, duration in enumerate(np.diff(times)):
        scale = np.tile([1.0, duration, duration**2], 2)
        block = slice(3 * k, 3 * k + 6)
        cost[block, block] += _COST * np.outer(scale, scale) / duration**5
    knots = np.stack([x, v, a], axis=1).ravel()
    free = np.isnan(knots)
    scale = 1 / np.sqrt(np.diag(cost)[free])
    system = cost[np.ix_(free, free)] * np.outer(scale, scale)
    knots[free] = scale * np.linalg.solve(system, -scale * (cost[np.ix_(free, ~free)] @ knots[~free]))
    return knots[1::3], knots[2::3]


@given(st.integers(0, 2**32 - 1), st.integers(2, 12))
def test_it_is_the_dense_solution(seed, count):
    rng = np.random.default_rng(seed)
    times = 3.0 + np.cumsum(10 ** rng.uniform(-1, 1, count))
    x, v, a = rng.uniform(-1, 1, (3, count, 3))
    v[rng.random((count, 3)) < 0.7] = np.nan
    a[rng.random((count, 3)) < 0.7] = np.nan
    v[[0, -1]], a[[0, -1]] = rng.uniform(-1, 1, (2, 2, 3))
    got_v, got_a = minimum_jerk(times, x, v, a)
    for axis in range(3):
        want_v, want_a = dense(times, x[:, axis], v[:, axis], a[:, axis])
        np.testing.assert_allclose(got_v[:, axis], want_v, rtol=1e-7, atol=1e-7 * np.abs(want_v).max())
        np.testing.assert_allclose(got_a[:, axis], want_a, rtol=1e-7, atol=1e-7 * np.abs(want_a).max())
    np.testing.assert_array_equal(got_v[~np.isnan(v)], v[~np.isnan(v)])
    np.testing.assert_array_equal(got_a[~np.isnan(a)], a[~np.isnan(a)])


def test_many_points_are_those_of_a_quintic_spline():
    """With free inner knots, the minimum is the clamped spline of degree five."""
    times = np.cumsum(np.random.default_rng(0).uniform(0.5, 1.5, 300))
    x = np.stack([np.sin(times), np.cos(0.3 * times), times], axis=1)
    rates = np.full_like(x, np.nan)
    rates[0] = rates[-1] = 0.0
    v, a = minimum_jerk(times, x, rates, rates)
    ends = [(1, np.zeros(3)), (2, np.zeros(3))]
    spline = make_interp_spline(times, x, k=5, bc_type=(ends, ends))
    np.testing.assert_allclose(v, spline(times, 1), atol=1e-8)
    np.testing.assert_allclose(a, spline(times, 2), atol=1e-8)


@pytest.mark.slow
def test_a_large_table_is_right_and_no_loop_of_python():
    times = np.arange(100_000) * 0.01
    share = np.sin(0.3 * times)
    x = np.stack([share, 2 * share, 1000 + share], axis=1)
    half = 0.5 * times
    q = np.stack([np.cos(half), np.zeros_like(half), np.zeros_like(half), np.sin(half)], axis=1)  # 1 rad/s about z
    interpolate(times[:3], x[:3], q[:3])  # compiles
    motion, count = calls(lambda: interpolate(times, x, q))
    assert count < 0.1 * len(times)  # 1100, however many
    for t in (100.0, 333.3333, 777.777):
        sample = motion.sample(t)
        np.testing.assert_allclose(sample[:3] - [0, 0, 1000], np.sin(0.3 * t) * np.array([1, 2, 1]), atol=1e-9)
        np.testing.assert_allclose(sample[7:10], 0.3 * np.cos(0.3 * t) * np.array([1, 2, 1]), atol=1e-8)
        np.testing.assert_allclose(sample[13:16], -0.09 * np.sin(0.3 * t) * np.array([1, 2, 1]), atol=1e-5)
        np.testing.assert_allclose(sample[10:13], [0, 0, 1], atol=1e-9)
        np.testing.assert_allclose(
            rotations.matrix(sample[3:7]), rotations.matrix(rotations.from_rpy(0, 0, t)), atol=1e-9
        )
