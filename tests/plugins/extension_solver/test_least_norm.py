"""The conformance kit, and the same bits as a Python twin."""

import numpy as np
import pytest
from cdpr_least_norm.solver import LeastNorm

from cdpr.native.cholesky import solve_positive_definite
from cdpr.tension import Status
from cdpr.testing import plugin_checks, samples


@pytest.mark.parametrize("check", plugin_checks("solver", "least_norm"), ids=str)
def test_least_norm(check):
    check()


def dot(a, b):
    total = 0.0
    for x, y in zip(a, b, strict=True):
        total += x * y
    return total


def test_same_bits():
    robot, rng = samples.braced(), np.random.default_rng(0)
    solver, tension = LeastNorm(robot, None), np.empty(robot.m)
    for _ in range(300):
        W, wrench = rng.normal(size=(robot.n, robot.m)), rng.normal(size=robot.n)
        assert solver.solve(W, wrench, np.zeros(robot.m), np.full(robot.m, 9.0), tension) == Status.OK
        x = solve_positive_definite([[dot(a, b) for b in W] for a in W], wrench)
        np.testing.assert_array_equal(tension, [dot(column, x) for column in W.T])
