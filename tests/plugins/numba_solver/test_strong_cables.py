"""The conformance kit, and the same bits as without numba."""

import numpy as np
import pytest
from cdpr_strong_cables.solver import StrongCables, distribute

from cdpr.testing import plugin_checks, samples


@pytest.mark.parametrize("check", plugin_checks("solver", "strong_cables"), ids=str)
def test_strong_cables(check):
    check()


def test_same_bits():
    robot, rng = samples.braced(), np.random.default_rng(0)
    solver, tension, python = StrongCables(robot, None), np.empty(robot.m), np.empty(robot.m)
    for _ in range(100):
        W, wrench, high = rng.normal(size=(robot.n, robot.m)), rng.normal(size=robot.n), rng.uniform(1, 9, robot.m)
        status = solver.solve(W, wrench, np.zeros(robot.m), high, tension)
        assert status == distribute(W, wrench, high, python, np.empty(W.shape), np.empty(robot.n))
        np.testing.assert_array_equal(tension, python)
