"""Check of an answer in the kernel library: lanes, reports."""

from __future__ import annotations

import numpy as np
from kernel_cases import HOSTILE, assert_same_bits, run, run_lanes

from cdpr.tension.compiled import accept_tension
from cdpr.tension.status import Status

SHAPES = [(1, 2), (2, 3), (3, 7), (6, 8), (6, 12)]
EACH = 64  # of each shape, a multiple of eight
NAMES = ("matrix", "wrench", "weights", "limits", "answer")


def answers(rng, n, m):
    """Answers that hold, those that miss a limit or the wrench by about the tolerances, absurd and hostile ones."""
    W, weights = rng.normal(size=(EACH, n, m)), rng.uniform(0.3, 3.0, (EACH, n))
    size = 10.0 ** rng.choice([0.0, 0.0, -4.0, 200.0], EACH)[:, None]  # of robots held by millinewtons, and absurd ones
    limits = np.sort(rng.uniform(0.0, 400.0, (EACH, 2, m)), axis=1) * size[:, None]
    limits[::5, 1, : m // 2] = limits[::5, 0, : m // 2]  # locked cables
    share = rng.choice([0.5, 0.5, 0.0, 1.0, 1.0 + 1e-9, 1.1], (EACH, m))
    share[::2] = np.minimum(share[::2], 1.0)  # within the limits
    answer = limits[:, 0] + share * (limits[:, 1] - limits[:, 0])
    wrench = np.einsum("knm,km->kn", W, answer) * (1.0 + rng.choice([0.0, 1e-8, 1e-6, 1e-5], (EACH, 1)))
    for k in range(0, EACH, 7):
        (W[k, 0], wrench[k], limits[k, 0], limits[k, 1], answer[k])[k % 5][0] = rng.choice(HOSTILE)
    return dict(zip(NAMES, (W, wrench, weights, limits, answer), strict=True))


def test_it_is_as_in_each_lane():
    rng, statuses = np.random.default_rng(1), np.zeros(5, dtype=int)
    for n, m in SHAPES:
        inputs = answers(rng, n, m)
        before = {"tension": rng.normal(size=(EACH, m)), "report": rng.normal(size=(EACH, 4))}
        shapes = {"tension": (m,), "report": (4,)}
        found, codes = run("accept", inputs, shapes, before=before)
        lanes, groups = run_lanes("accept", inputs, shapes, before=before)
        for key in shapes:
            assert_same_bits(lanes[key], found[key])
        assert [group >> lane & 1 for group in groups for lane in range(8)] == [int(code != 0) for code in codes]
        statuses += np.bincount(codes, minlength=5)
    assert (statuses[[Status.OK, Status.NOT_FOUND, Status.BAD_INPUT]] > 2).all()


def test_the_function_clips_and_reports():
    tension, report = accept_tension([[1.0, -1.0]], [2.0], [1.0], [1.0, 4.0 + 1e-7], [9.0, 9.0], [6.0, 4.0])
    np.testing.assert_array_equal(tension, [6.0, 4.0 + 1e-7])
    np.testing.assert_allclose(report, [Status.OK, 0.0, -1e-7, 1.0])
    tension, report = accept_tension([[1.0, -1.0]], [2.0], [1.0], [1.0, 1.0], [9.0, 9.0], [6.0, 5.0])
    assert np.isnan(tension).all()
    np.testing.assert_allclose(report, [Status.NOT_FOUND, 1.0, 3.0, 0.0])
    assert accept_tension([[1.0]], [np.nan], [1.0], [0.0], [9.0], [6.0])[1][0] == Status.BAD_INPUT
