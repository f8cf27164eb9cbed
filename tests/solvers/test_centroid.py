"""The solver centroid: against vertices found one by one, the edges of its domain, locked cables, continuity."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from conftest import crossed_box, make_robot, random_state
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import null_space
from scipy.spatial import ConvexHull

from cdpr.mechanics import kinematics
from cdpr.plugins import PluginOptions
from cdpr.tension import Status
from cdpr_solvers.centroid import Centroid

seeds = st.integers(0, 2**32 - 1)
LOW, HIGH = 10.0, 500.0


def problem(seed: int, m: int):
    """A robot, its W, and tensions within the limits that balance the wrench W t."""
    rng = np.random.default_rng(seed)
    robot = make_robot(crossed_box(rng, m), limits=(LOW, HIGH))
    W = kinematics.wrench_matrix(robot, random_state(rng))
    return robot, W, rng.uniform(LOW, HIGH, m)


def solve(robot, W, wrench, low=None, high=None):
    tension = np.full(W.shape[1], np.nan)
    low = np.full(robot.m, LOW) if low is None else low
    high = np.full(robot.m, HIGH) if high is None else high
    return Centroid(robot, PluginOptions()).solve(W, wrench, low, high, tension), tension


def centroid_of(W, t):
    """The centroid by brute force: all tensions with r cables at a limit, those that are admissible, their hull."""
    N = null_space(W)
    m, r = N.shape
    found = []
    for cables in combinations(range(m), r):
        rows = N[list(cables)]
        if abs(np.linalg.det(rows)) < 1e-9:
            continue
        for sides in np.ndindex(*([2] * r)):
            x = np.linalg.solve(rows, np.where(sides, HIGH, LOW) - t[list(cables)])
            if np.all((t + N @ x > LOW - 1e-7) & (t + N @ x < HIGH + 1e-7)):
                found.append(x)
    points = np.array(found)
    if r == 1:
        return t + N @ ((points.min(axis=0) + points.max(axis=0)) / 2)
    hull = points[ConvexHull(points).vertices]
    a, b = hull - hull[0], np.roll(hull, -1, axis=0) - hull[0]
    areas = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return t + N @ (hull[0] + (areas[:, None] * (a + b)).sum(axis=0) / (3.0 * areas.sum()))


@given(seeds, st.sampled_from([7, 8]))
def test_it_is_the_centroid(seed, m):
    robot, W, inside = problem(seed, m)
    status, t = solve(robot, W, W @ inside)
    assert status == Status.OK
    np.testing.assert_allclose(W @ t, W @ inside, atol=1e-9 * HIGH)
    np.testing.assert_allclose(t, centroid_of(W, inside), atol=1e-5)


@given(seeds)
def test_without_redundancy_the_tensions_are_determined(seed):
    robot, W, inside = problem(seed, 6)
    status, t = solve(robot, W, W @ inside)
    assert status == Status.OK
    np.testing.assert_allclose(t, inside, rtol=1e-6)
    inside[3] = HIGH + 1.0
    assert solve(robot, W, W @ inside)[0] == Status.INFEASIBLE


@pytest.mark.parametrize("m", [9, 12])
def test_more_than_two_redundant_cables_are_unsupported(m):
    robot, W, inside = problem(1, m)
    assert solve(robot, W, W @ inside)[0] == Status.UNSUPPORTED


def test_locked_and_cut_cables_are_not_redundant():
    robot, W, inside = problem(1, 9)
    low, high = robot.tension_min.copy(), robot.tension_max.copy()
    inside[4] = low[4] = high[4] = 0.0
    status, t = solve(robot, W, W @ inside, low, high)
    rest = np.arange(9) != 4
    assert status == Status.OK
    assert t[4] == 0.0
    np.testing.assert_allclose(t[rest], centroid_of(W[:, rest], inside[rest]), atol=1e-5)


@given(seeds, st.sampled_from([7, 8]))
def test_the_last_admissible_wrench_has_one_answer(seed, m):
    """Along a direction y the cables can pull so much and no more: there the set is a point."""
    robot, W, _ = problem(seed, m)
    c = W.T @ np.random.default_rng(seed).normal(size=6)
    if np.abs(c).min() < 1e-3:
        return
    only = np.where(c > 0.0, HIGH, LOW)
    status, t = solve(robot, W, W @ only)
    assert status == Status.OK
    np.testing.assert_allclose(t, only, atol=1e-6)
    assert solve(robot, W, W @ (only + 0.01 * np.sign(c)))[0] == Status.INFEASIBLE


@given(seeds, st.sampled_from([7, 8]))
def test_it_shrinks_to_that_answer_without_a_jump(seed, m):
    robot, W, inside = problem(seed, m)
    c = W.T @ np.random.default_rng(seed).normal(size=6)
    if np.abs(c).min() < 1e-3:
        return
    only = np.where(c > 0.0, HIGH, LOW)
    away = []
    for share in (1e-2, 1e-4, 1e-6, 1e-8):
        status, t = solve(robot, W, W @ (only + share * (inside - only)))
        assert status == Status.OK
        away.append(np.abs(t - only).max())
    assert away[-1] <= max(2e-6 * away[0], 1e-5)


def test_unbounded_limits_and_bad_input():
    robot, W, inside = problem(1, 8)
    low, high = np.full(8, LOW), np.full(8, np.inf)
    assert solve(robot, W, W @ inside, low, high)[0] == Status.UNSUPPORTED
    assert solve(robot, W, np.full(6, np.nan))[0] == Status.BAD_INPUT
    assert solve(robot, W, W @ inside, np.full(8, HIGH), np.full(8, LOW))[0] == Status.BAD_INPUT
