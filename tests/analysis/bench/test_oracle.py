"""Oracle of the benchmark against cases worked by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from bench_cases import carriage, wall

from cdpr.analysis.bench.oracle import OBJECTIVES, Oracle, consult
from cdpr.analysis.bench.problems import Problems, make_problems
from cdpr_solvers.qp import MinimumNorm

LIMITS = (10.0, 100.0)


def between(*wrenches: float) -> Oracle:
    """Two opposing cables of 10 to 100 N: t_1 - t_2 = wrench."""
    W = np.tile([[1.0, -1.0]], (len(wrenches), 1, 1))
    return consult(Problems(carriage(limits=LIMITS), W, np.array(wrenches)[:, None]), OBJECTIVES)


def test_margin_of_two_opposing_cables():
    # t_1 <= 100 - s and t_2 >= 10 + s, so that wrench <= 90 - 2 s.
    found = between(0.0, 80.0, -80.0, 95.0, 90.0)
    np.testing.assert_allclose(found.margin, [45.0, 5.0, 5.0, -2.5, 0.0], atol=1e-7)
    assert found.feasible.tolist() == [True, True, True, False, False]
    assert found.infeasible.tolist() == [False, False, False, True, False]


def test_within_round_off_of_the_edge_nothing_is_decided():
    just = 1e-7 * 100.0  # of the margin, twice that of the wrench
    found = between(90 - 4 * just, 90 - just, 90 + just, 90 + 4 * just)
    assert found.feasible.tolist() == [True, False, False, False]
    assert found.infeasible.tolist() == [False, False, False, True]


def test_wrench_that_no_cable_can_pull():
    robot = replace(carriage(1), dof=("x", "z"))
    found = consult(Problems(robot, np.array([[[1.0], [0.0]]] * 2), np.array([[50.0, 1.0], [50.0, 0.0]])))
    assert found.margin.tolist() == [-np.inf, pytest.approx(40.0)]
    assert found.infeasible.tolist() == [True, False]


def test_optima_of_two_opposing_cables():
    optima = between(20.0, 200.0).optima
    np.testing.assert_allclose(optima["min_norm"][0], [30.0, 10.0])
    np.testing.assert_allclose(optima["mid_range"][0], [65.0, 45.0])
    np.testing.assert_allclose(optima["one_norm"][0], [30.0, 10.0])
    np.testing.assert_allclose(optima["max_slack"][0], [65.0, 45.0])
    assert all(np.isnan(optima[name][1]).all() for name in OBJECTIVES)


def test_only_the_given_goals_are_optimised():
    problems = make_problems(wall(), 3, 1)
    assert consult(problems).optima == {}
    assert list(consult(problems, ["None", "one_norm", "centroid"]).optima) == ["one_norm"]


@pytest.mark.slow
def test_the_exact_solver_agrees():
    problems = make_problems(wall(), 150, 2)
    found = consult(problems, ["min_norm"])
    solver, t = MinimumNorm(wall(), None), np.zeros(4)
    for k in range(150):
        status = solver.solve(problems.W[k], problems.wrench[k], wall().tension_min, wall().tension_max, t)
        assert (status == 0) == found.feasible[k]
        if status == 0:
            np.testing.assert_allclose(t, found.optima["min_norm"][k], atol=1e-8)
    assert 10 < found.feasible.sum() < 140


def test_first():
    found = between(0.0, 80.0, 95.0).first(2)
    assert len(found.margin) == len(found.feasible) == len(found.infeasible) == len(found.optima["one_norm"]) == 2
