"""Interval and polygon of the admissible distributions, against scipy and in degenerate cases."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial import HalfspaceIntersection, QhullError

from cdpr.tension import safest
from cdpr.tension.polygon import _cut, _tidy, centre_of_polygon, clip_interval, clip_polygon, most_vertices

seeds = st.integers(0, 2**32 - 1)


def corners(N, c, low, high):
    m = len(c)
    vertices = np.full((most_vertices(m), 2), np.nan)
    arrays = (np.ascontiguousarray(a, dtype=float) for a in (N, c, low, high))
    count = clip_polygon(*arrays, vertices, np.zeros((most_vertices(m), 2)))
    return vertices[:count]


def ends(g, c, low, high):
    out = np.zeros(2)
    count = clip_interval(np.array(g, dtype=float)[:, None], *(np.array(a, dtype=float) for a in (c, low, high)), out)
    return out[:count]


def middle(vertices):
    x = np.zeros(2)
    centre_of_polygon(np.ascontiguousarray(vertices), len(vertices), x)
    return x


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


@given(seeds, st.sampled_from([1e-3, 1e-6, 1e-9, 1e-11]))
def test_a_thin_polygon_has_its_centroid_within(seed, width):
    rng = np.random.default_rng(seed)
    turn = rng.uniform(0, np.pi)
    along, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    N, c = np.array([along, across]), rng.uniform(-1.0, 1.0, 2)
    low = rng.uniform(1.0, 5.0, 2)
    high = low + np.array([100.0, width])
    np.testing.assert_allclose(c + N @ middle(corners(N, c, low, high)), (low + high) / 2, atol=1e-9 + 1e-12 / width)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_non_finite_input_ends(bad):
    assert len(corners([[1, 0], [0, 1]], [bad, 0], [0, 0], [1, 1])) == 0
    corners([[bad, 0], [0, 1]], [0, 0], [0, 0], [1, 1])
    assert len(ends([1], [bad], [0], [1])) == 0


def test_limits_that_miss_each_other_by_round_off_are_broken_alike():
    """Neither cable bears more of it, in newtons, however unequal their rows."""
    missed, scale = 8e-9, 1000.0  # m of x; the tolerance is 1e-9 N
    found = ends([1.0, 0.1, 0.0], [0.0, 0.0, scale], [2.0 + missed, -scale, scale], [scale, 0.2, scale])
    assert len(found) == 1
    first, second = 2.0 + missed - found[0], 0.1 * found[0] - 0.2
    assert first == pytest.approx(second, rel=1e-6)
    assert 0.0 < first < 1e-9


def test_a_cut_along_an_edge_adds_no_corner_outside():
    """Both ends of the edge lie beyond the cut, one of them by less than the tolerance."""
    tolerance = 1e-9
    old = np.array([[0.0, 0.9e-9], [1.0, 1.1e-9], [1.0, -5.0], [0.0, -5.0]])
    new = np.zeros((8, 2))
    count = _cut(old, 4, 0.0, 1.0, 0.0, tolerance, new)
    assert count >= 4
    assert np.all((new[:count] >= old.min(axis=0)) & (new[:count] <= old.max(axis=0)))


@pytest.mark.parametrize("first", range(3))
def test_of_a_polygon_without_breadth_the_far_ends_remain(first):
    corners = np.roll(np.array([[0.0, 0.0], [50.0, -2e-10], [100.0, 0.0]]), first, axis=0)
    kept = np.zeros((3, 2))
    assert _tidy(corners, 3, 1e-9, kept) == 2
    assert sorted(kept[:2, 0]) == [0.0, 100.0]


def test_a_polygon_of_some_breadth_stays_one():
    corners = np.array([[0.0, 0.0], [50.0, -4e-9], [100.0, 0.0]])  # area / circumference is the tolerance twice over
    assert _tidy(corners, 3, 5e-10, np.zeros((3, 2))) == 3


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
        x = np.zeros(max(r, m))
        work = np.zeros((safest.work_rows(m), 2 * m + 1))
        found = safest.safest_point(ball, np.ascontiguousarray(N), r, np.array([c, low, high]), x, work)
        assert found == pytest.approx(wanted, abs=1e-6 * high.max())
        slack = np.minimum(c + N @ x[:r] - low, high - c - N @ x[:r]) / size[:, 0]
        assert slack.min() == pytest.approx(found, abs=1e-9 * high.max())
