"""Interval and polygon of the admissible distributions, against scipy and in degenerate cases."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial import HalfspaceIntersection, QhullError

from cdpr.tension.admissible import admissible_corners, farthest_from_limits

seeds = st.integers(0, 2**32 - 1)


def corners(N, c, low, high):
    return admissible_corners(np.array(N, dtype=float), c, low, high)


def ends(g, c, low, high):
    return admissible_corners(np.array(g, dtype=float)[:, None], c, low, high)[:, 0]


def middle(v):
    """Centroid of a polygon, or the mean of fewer corners."""
    x, y = (v - v[0]).T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    if len(v) < 3:
        return v.mean(axis=0)
    sums = [((each + np.roll(each, -1)) * cross).sum() for each in (x, y)]
    return v[0] + np.array(sums) / (3.0 * cross.sum())


def area(v):
    x, y = v.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def random_set(seed, r):
    """An orthonormal N (m, r), c orthogonal to it, and limits that c + N x keeps or not."""
    rng = np.random.default_rng(seed)
    m = int(rng.integers(r + 1, 13))
    Q = np.linalg.qr(rng.normal(size=(m, m)))[0]
    low = rng.uniform(1.0, 50.0, m)
    high = low + rng.choice([5.0, 100.0, 6000.0]) * rng.uniform(0.1, 1.0, m)
    inside = low + rng.uniform(-0.2, 1.2, m) * (high - low)
    N = Q[:, :r]
    return N, inside - N @ (N.T @ inside), low, high


def inner_point(N, c, low, high):
    """Centre and radius of the largest circle in the set, by HiGHS; the radius is negative where it is empty."""
    size = np.linalg.norm(N, axis=1)[:, None]
    A = np.vstack([np.hstack([N, size]), np.hstack([-N, size])])
    best = linprog([0, 0, -1], A, np.concatenate([high - c, c - low]), bounds=[(None, None)] * 3)
    return best.x[:2], best.x[2]


@given(seeds)
def test_polygon_is_scipys(seed):
    N, c, low, high = random_set(seed, 2)
    point, radius = inner_point(N, c, low, high)
    found = corners(N, c, low, high)
    if abs(radius) < 1e-6:
        return  # a linear program with its own tolerances is no oracle here
    if radius < 0.0:
        assert len(found) == 0
        return
    assert len(found) >= 3
    try:
        wanted = HalfspaceIntersection(
            np.vstack([np.hstack([N, (c - high)[:, None]]), np.hstack([-N, (low - c)[:, None]])]), point
        ).intersections
    except QhullError:
        return
    scale = np.abs(wanted).max()
    near = np.linalg.norm(found[:, None] - wanted[None], axis=2)
    assert near.min(axis=1).max() < 1e-7 * scale  # each of ours is one of scipy's, and the other way round
    assert near.min(axis=0).max() < 1e-7 * scale
    assert area(found) > 0.0  # anticlockwise
    t = c + found @ N.T
    assert np.all((t >= low - 1e-11 * scale) & (t <= high + 1e-11 * scale))


@given(seeds)
def test_interval_is_a_linear_programs(seed):
    N, c, low, high = random_set(seed, 1)
    g = N[:, 0]
    wanted = [linprog([s], np.stack([g, -g], axis=1).T.reshape(-1, 1), np.concatenate([high - c, c - low]),
                      bounds=[(None, None)]) for s in (1, -1)]  # fmt: skip
    found = ends(g, c, low, high)
    if wanted[0].status == 0:
        np.testing.assert_allclose(found, [wanted[0].x[0], wanted[1].x[0]], atol=1e-6)
    else:
        assert len(found) == 0


@given(seeds, st.floats(0.0, 2.0 * np.pi))
def test_limits_twice_or_in_another_order_change_nothing(seed, turn):
    N, c, low, high = random_set(seed, 2)
    once = corners(N, c, low, high)
    order = np.random.default_rng(seed).permutation(len(c))
    twice = np.concatenate([order, order])
    again = corners(N[twice], c[twice], low[twice], high[twice])
    assert len(once) == len(again)
    if len(once):
        np.testing.assert_allclose(middle(again), middle(once), atol=1e-7 * high.max())
        R = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])  # another basis
        np.testing.assert_allclose(middle(corners(N @ R.T, c, low, high)), R @ middle(once), atol=1e-7 * high.max())


# The unit square by its four sides, N not orthonormal: two cables along x and y, then what a case adds.
SQUARE = ([[1, 0], [0, 1]], [0, 0], [0, 0], [1, 1])


def with_row(row, c, low, high):
    N, c0, low0, high0 = SQUARE
    return [*N, row], [*c0, c], [*low0, low], [*high0, high]


@pytest.mark.parametrize(
    ("case", "expected"),
    [
        (SQUARE, [[0, 0], [1, 0], [1, 1], [0, 1]]),
        (with_row([1, 0], 0, 0, 1), [[0, 0], [1, 0], [1, 1], [0, 1]]),  # duplicate limits
        (with_row([-1, 0], 0, -1, 0), [[0, 0], [1, 0], [1, 1], [0, 1]]),  # the same, seen from the other side
        (with_row([1, 0], 0, 0.5, 2), [[0.5, 0], [1, 0], [1, 1], [0.5, 1]]),  # parallel limits
        (with_row([0, 0], 3, 2, 4), [[0, 0], [1, 0], [1, 1], [0, 1]]),  # a cable that x cannot change
        (with_row([0, 0], 3, 3, 3), [[0, 0], [1, 0], [1, 1], [0, 1]]),
        (with_row([0, 0], 3, 4, 5), []),  # nor keep within its limits
        (with_row([1, 1], 0, 0, 1), [[0, 0], [1, 0], [0, 1]]),
        (with_row([1, 0], 0, 1, 2), [[1, 0], [1, 1]]),  # a segment
        (with_row([1, 0], 0, 0.3, 0.3), [[0.3, 0], [0.3, 1]]),  # a locked cable
        (with_row([1, 1], 0, 1, 1), [[0, 1], [1, 0]]),
        (with_row([1, 1], 0, 2, 9), [[1, 1]]),  # a point
        (with_row([1, 1], 0, 2.001, 9), []),
        (with_row([1, 0], 0, 1.001, 2), []),
        (with_row([1, 0], 0, 1, 0), []),  # limits that contradict each other
        (([[1, 0], [0, 1], [1, 1]], [0, 0, 0], [2, 3, 5], [2, 3, 5]), [[2, 3]]),  # every cable locked
        (([[1, 0], [0, 1], [1, 1]], [0, 0, 0], [2, 3, 4], [2, 3, 4]), []),
    ],
)
def test_polygons_without_round_off(case, expected):
    found = corners(*case)
    assert sorted(map(tuple, found.round(12) + 0.0)) == sorted(map(tuple, np.array(expected, dtype=float)))
    if expected:
        assert np.all(np.abs(middle(found) - np.mean(expected, axis=0)) < 1e-12)


@pytest.mark.parametrize(
    ("g", "c", "low", "high", "expected"),
    [
        ([1], [0], [2], [5], [2, 5]),
        ([-2], [0], [2], [5], [-2.5, -1]),
        ([1, 1], [0, 0], [2, 3], [5, 9], [3, 5]),
        ([1, -1], [0, 0], [2, -2], [5, 9], [2]),  # a point
        ([1, -1], [0, 0], [2, -1.9], [5, 9], []),
        ([1, 0], [0, 7], [2, 7], [5, 7], [2, 5]),
        ([1, 0], [0, 7], [2, 8], [5, 9], []),
        ([1], [0], [4], [4], [4]),
        ([1], [0], [5], [4], []),
        ([1, 1e-3], [0, 0], [2, 0.002], [2, 3], [2]),
    ],
)
def test_intervals_without_round_off(g, c, low, high, expected):
    np.testing.assert_allclose(ends(g, c, low, high), expected, rtol=1e-14)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_non_finite_input_ends(bad):
    assert len(corners([[1, 0], [0, 1]], [bad, 0], [0, 0], [1, 1])) == 0
    corners([[bad, 0], [0, 1]], [0, 0], [0, 0], [1, 1])
    assert len(ends([1], [bad], [0], [1])) == 0


def test_limits_that_miss_each_other_by_round_off_are_broken_alike():
    """Neither cable carries more of it, in newtons, for any rows."""
    missed, scale = 8e-9, 1000.0  # m of x; the tolerance is 1e-9 N
    found = ends([1.0, 0.1, 0.0], [0.0, 0.0, scale], [2.0 + missed, -scale, scale], [scale, 0.2, scale])
    assert len(found) == 1
    first, second = 2.0 + missed - found[0], 0.1 * found[0] - 0.2
    assert first == pytest.approx(second, rel=1e-6)
    assert 0.0 < first < 1e-9


@pytest.mark.parametrize("ball", [True, False])
@pytest.mark.parametrize("r", [1, 2, 3])
@pytest.mark.usual("1-*", "3-True")
def test_the_safest_point_is_a_linear_programs(ball, r):
    """Radius of the largest ball, or largest slack; negative by as much where the set is empty."""
    for seed in range(20):
        N, c, low, high = random_set(seed, r)
        m = len(c)
        size = np.linalg.norm(N, axis=1)[:, None] if ball else np.ones((m, 1))
        A = np.vstack([np.hstack([N, size]), np.hstack([-N, size])])
        wanted = linprog([*[0] * r, -1], A, np.concatenate([high - c, c - low]), bounds=[(None, None)] * (r + 1)).x[r]
        found, x = farthest_from_limits(N, c, low, high, ball=ball)
        assert found == pytest.approx(wanted, abs=1e-6 * high.max())
        slack = np.minimum(c + N @ x - low, high - c - N @ x) / size[:, 0]
        assert slack.min() == pytest.approx(found, abs=1e-9 * high.max())
