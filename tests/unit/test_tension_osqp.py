"""OSQP as a solver against the exact one."""

from __future__ import annotations

import numpy as np
import pytest
from test_tension_qp import margin, problem, solve

from cdpr.tension import Status
from cdpr_solvers.osqp import Osqp

OPTIMUM = 1e-5  # N from the exact optimum, tensions up to 500 N; measured 3e-7
CERTAIN = 1e-3  # N of margin below which a first-order method may err about feasibility


def call(solver, robot, W, wrench, low=None, high=None):
    t = np.full(robot.m, np.nan)
    low = robot.tension_min if low is None else low
    high = robot.tension_max if high is None else high
    return solver.solve(W, wrench, low, high, t), t


@pytest.mark.parametrize("m", [4, 6, 8, 12])
def test_it_agrees_with_qp_over_one_set_up(m):
    """Feasible and infeasible problems in turn: each answer is right, whatever came before."""
    solver, seen = None, set()
    for seed in range(40):
        robot, W, wrench = problem(seed, m, [0.0, 60.0, 300.0, 1500.0][seed % 4])
        if seed % 3 == 0:
            wrench = W @ np.random.default_rng(seed).uniform(10.0, 500.0, m)
        solver = solver or Osqp(robot, None)
        status, t = call(solver, robot, W, wrench)
        exact, best = solve(robot, W, wrench)
        if exact != status:
            assert abs(margin(W, wrench, robot.tension_min, robot.tension_max)) < CERTAIN
        elif status == Status.OK:
            assert np.abs(t - best).max() < OPTIMUM
        seen.add(status)
    assert seen == {Status.OK, Status.INFEASIBLE}


def test_the_same_calls_give_the_same_bits():
    robot = problem(0, 8, 0.0)[0]
    solver, other = Osqp(robot, None), Osqp(robot, None)
    calls = [problem(seed, 8, 40.0)[1:] for seed in range(10)]
    first = [call(solver, robot, *each) for each in calls]
    solver.reset()
    for again in ([call(solver, robot, *each) for each in calls], [call(other, robot, *each) for each in calls]):
        for (status, t), (wanted, expected) in zip(again, first, strict=True):
            assert status == wanted
            np.testing.assert_array_equal(t, expected)


def test_entries_of_w_that_are_zero_at_first_may_change():
    robot, W, _ = problem(3, 8, 0.0)
    solver = Osqp(robot, None)
    hollow = np.where(np.abs(W) > 0.5, W, 0.0)
    inside = np.linspace(60.0, 200.0, 8)
    for matrix in (hollow, W, hollow, np.asfortranarray(W)):
        status, t = call(solver, robot, matrix, matrix @ inside)
        assert status == Status.OK
        np.testing.assert_allclose(matrix @ t, matrix @ inside, atol=1e-6)


def test_locked_cables_keep_their_tension():
    robot, W, _ = problem(5, 9, 0.0)
    inside = np.linspace(60.0, 200.0, 9)
    low, high = robot.tension_min.copy(), robot.tension_max.copy()
    low[4] = high[4] = inside[4]
    status, t = call(Osqp(robot, None), robot, W, W @ inside, low, high)
    assert status == Status.OK
    assert t[4] == pytest.approx(inside[4], abs=1e-6)


def test_bad_input_is_said_and_forgotten(capfd):
    """The library itself would print a line and answer the previous problem."""
    robot, W, _ = problem(1, 8, 0.0)
    wrench = W @ np.linspace(60.0, 200.0, 8)
    solver = Osqp(robot, None)
    before = call(solver, robot, W, wrench)
    broken = W.copy()
    broken[0, 0] = np.nan
    for bad in (np.nan, np.inf):
        assert call(solver, robot, W, wrench * bad)[0] == Status.BAD_INPUT
    assert call(solver, robot, broken, wrench)[0] == Status.BAD_INPUT
    assert call(solver, robot, W, wrench, robot.tension_max, robot.tension_min)[0] == Status.BAD_INPUT
    after = call(solver, robot, W, wrench)
    assert after[0] == before[0] == Status.OK
    np.testing.assert_allclose(after[1], before[1], atol=OPTIMUM)
    assert capfd.readouterr() == ("", "")
