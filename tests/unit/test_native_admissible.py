"""Admissible intervals and polygons, and their safest points, in the kernel library: the bits of the numba kernels."""

from __future__ import annotations

import numpy as np
import pytest
from kernel_cases import COUNT, HOSTILE, assert_same_bits, rubbish, run
from solver_kernel_cases import compiled

from cdpr.tension import polygon, safest
from cdpr.tension.admissible import admissible_corners, farthest_from_limits

EACH = -(-COUNT // 16 // 8) * 8


def polytopes(rng, m, r):
    """Half of them sound; others with rows that x does not change, equal cables, equal, close, hostile or no limits."""
    basis, center = rng.normal(size=(EACH, m, r)), rng.normal(size=(EACH, m)) * 50.0
    low, high = rng.uniform(-60.0, 0.0, (EACH, m)), rng.uniform(0.0, 60.0, (EACH, m))
    for k in range(EACH // 2, EACH):
        i = rng.integers(m)
        match k % 8:
            case 0:
                basis[k, i] = 0.0
            case 1:
                basis[k, i] = basis[k, rng.integers(m)] * rng.choice([1.0, -1.0, 1e-8])
            case 2:
                low[k, i] = high[k, i]
            case 3:
                low[k, i], high[k, i] = center[k, i], center[k, i] * (1.0 + rng.choice([0.0, 1e-13, 1e-11]))
            case 4:
                low[k, i] = rng.choice(HOSTILE)
            case 5:
                high[k, i] = rng.choice(HOSTILE)
            case 6:
                basis[k, i, rng.integers(r)] = rng.choice(HOSTILE)
            case 7:
                scale = 10.0 ** rng.uniform(-150.0, 150.0)
                center[k], low[k], high[k] = center[k] * scale, low[k] * scale, high[k] * scale
    return {"basis": basis, "box": np.stack([center, low, high], axis=1)}


@pytest.mark.slow
@compiled
@pytest.mark.parametrize("r", [1, 2])
def test_corners_have_the_bits_of_numba(r):
    rng = np.random.default_rng(2)
    counts = np.zeros(100, dtype=int)
    for m in range(1, 17):
        inputs, room = polytopes(rng, m, r), polygon.most_vertices(m)
        operation = "admissible_interval" if r == 1 else "admissible_polygon"
        found, codes = run(operation, inputs, {"corners": (room, r), "count": (1,)})
        corners, work = np.empty((room, 2)), np.empty((room, 2))
        for k in range(EACH):
            rubbish(corners)
            rubbish(work)
            N, (c, low, high) = inputs["basis"][k], inputs["box"][k]
            if r == 1:
                count = polygon.clip_interval(N, c, low, high, corners[0])
                expected = corners[0, :count, None]
            else:
                count = polygon.clip_polygon(N, c, low, high, corners, work)
                expected = corners[:count]
            assert count == found["count"][k, 0]
            assert codes[k] == (count == 0)
            assert_same_bits(found["corners"][k, :count], expected)
            counts[count] += 1
    assert counts.sum() >= COUNT
    assert (counts[[0, 1, 2]] > 0).all()


@pytest.mark.slow
@compiled
@pytest.mark.parametrize("ball", [False, True])
def test_safest_points_have_the_bits_of_numba(ball):
    rng = np.random.default_rng(3)
    for m in range(1, 17):
        r = int(rng.integers(1, m + 1))
        inputs = polytopes(rng, m, r)
        found, codes = run("safest_point", inputs, {"x": (r,), "distance": (1,)}, ball=int(ball))
        work, x = np.empty((safest.work_rows(m), 2 * m + 1)), np.empty(r)
        for k in range(EACH):
            rubbish(work)
            rubbish(x)
            distance = safest.safest_point(ball, inputs["basis"][k], r, inputs["box"][k], x, work)
            assert_same_bits(found["distance"][k, 0], distance)
            assert (codes[k] != 0) == np.isnan(distance)
            if not np.isnan(distance):
                assert_same_bits(found["x"][k], x)


def test_functions_reject_wrong_shapes():
    with pytest.raises(ValueError, match=r"basis: expected shape \(m, 1\) or \(m, 2\)"):
        admissible_corners(np.ones((4, 3)), np.zeros(4), np.zeros(4), np.ones(4))
    with pytest.raises(ValueError, match="safest_point: box: expected shape"):
        farthest_from_limits(np.ones((4, 3)), np.zeros(3), np.zeros(3), np.ones(3))
