"""The closed form against numpy and the limits."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from hypothesis import given
from hypothesis import strategies as st
from test_qp import problem, solve

import cdpr
from cdpr.tension import Status
from cdpr_solvers.closed_form import ClosedForm

pytestmark = pytest.mark.core

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.integers(6, 12), st.sampled_from([0.0, 50.0, 300.0]))
def test_it_is_the_nearest_to_the_middle_or_not_found(seed, m, load):
    robot, W, wrench = problem(seed, m, load)
    middle = 0.5 * (robot.tension_min + robot.tension_max)
    expected = middle + np.linalg.pinv(W) @ (wrench - W @ middle)
    status, t = solve(robot, W, wrench, solver=ClosedForm)
    inside = np.minimum(expected - robot.tension_min, robot.tension_max - expected).min()
    if abs(inside) > 1e-3:
        # Beyond the ball through the corners of the limits nothing is feasible; with m = n there is no other solution.
        radius = 0.5 * np.linalg.norm(robot.tension_max - robot.tension_min)
        sure = m == robot.n or np.linalg.norm(expected - middle) > radius
        assert status == (Status.OK if inside > 0 else Status.INFEASIBLE if sure else Status.NOT_FOUND)
    np.testing.assert_allclose(t, expected, rtol=1e-8, atol=1e-7 * np.abs(expected).max())


@given(seeds)
def test_limits_may_differ_from_cable_to_cable(seed):
    robot, W, _ = problem(seed, 9, 0.0)
    rng = np.random.default_rng(seed)
    low = rng.uniform(0.0, 100.0, 9)
    high = low + rng.uniform(0.0, 500.0, 9)
    high[3] = low[3]
    status, t = solve(robot, W, W @ (0.5 * (low + high)), low, high, solver=ClosedForm)
    assert status == Status.OK
    np.testing.assert_allclose(t, 0.5 * (low + high), rtol=1e-9, atol=1e-7)


def test_a_wrench_beyond_the_range_of_w_is_infeasible():
    robot, W, _ = problem(1, 4, 0.0)
    middle = 0.5 * (robot.tension_min + robot.tension_max)
    assert solve(robot, W, W @ middle, solver=ClosedForm)[0] == Status.OK
    assert solve(robot, W, W @ middle + np.eye(6)[2], solver=ClosedForm)[0] == Status.INFEASIBLE


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_wrench_that_is_not_finite_is_never_ok(bad):
    robot, W, wrench = problem(1, 8, 0.0)
    wrench[2] = bad
    assert solve(robot, W, wrench, solver=ClosedForm)[0] != Status.OK


def test_it_runs_a_robot_held_from_all_sides():
    run = cdpr.simulate(
        ROOT / "scenarios" / "ipanema_1.yaml", solver="closed_form", overrides={"simulation.duration": 0.5}
    )
    assert not run.solver_status.any()
