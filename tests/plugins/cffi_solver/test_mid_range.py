"""The conformance kit, and the same bits as a Python twin."""

import math

import numpy as np
import pytest
from cdpr_mid_range.solver import MidRange

from cdpr.tension import Status
from cdpr.testing import plugin_checks, samples


@pytest.mark.parametrize("check", plugin_checks("solver", "cffi_mid_range"), ids=str)
def test_mid_range(check):
    check()


def dot(a, b):
    total = 0.0
    for x, y in zip(a, b, strict=True):
        total += x * y
    return total


def twin(W, wrench, low, high):
    """The kernel in Python, for rows that do not depend on each other."""
    t = 0.5 * (low + high)
    share = [w - dot(row, t) for w, row in zip(wrench, W, strict=True)]
    rows = []
    for k, row in enumerate(W.copy()):
        for j, before in enumerate(rows):
            along = dot(row, before)
            row -= along * before
            share[k] -= along * share[j]
        length = math.sqrt(dot(row, row))
        row /= length
        share[k] /= length
        t += share[k] * row
        rows.append(row)
    return t, Status.OK if ((low <= t) & (t <= high)).all() else Status.NOT_FOUND


def test_same_bits():
    robot, rng, answered = samples.braced(), np.random.default_rng(0), 0
    solver, tension = MidRange(robot, None), np.empty(robot.m)
    for _ in range(300):
        W, low, high = rng.normal(size=(robot.n, robot.m)), np.ones(robot.m), rng.uniform(2.0, 9.0, robot.m)
        wrench = W @ (0.5 * (low + high)) + rng.normal(size=robot.n)
        status = solver.solve(W, wrench, low, high, tension)
        expected = twin(W, wrench, low, high)
        assert status == expected[1]
        np.testing.assert_array_equal(tension, expected[0])
        answered += status == Status.OK
    assert 50 < answered < 250
