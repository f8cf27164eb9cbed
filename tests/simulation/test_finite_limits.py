"""A solver that requires finite tension limits is rejected with infinite ones before the run."""

from __future__ import annotations

import math

import pytest

import cdpr

pytestmark = pytest.mark.core


def scenario(solver, high, **section):
    robot = cdpr.load_robot("caroca")
    robot = robot.replace(cables=[cable.replace(tension_max=high) for cable in robot.cables])
    return cdpr.Scenario(robot=robot, simulation={"duration": 0.01}, solver={"type": solver, **section})


@pytest.mark.parametrize("solver", ["exact", "closed_form", "centroid"])
@pytest.mark.parametrize("policy", ["best_effort", "stop"])
def test_solvers_that_require_finite_limits(solver, policy):
    text = f"robot.tension.max: solver '{solver}' requires finite limits of all tensions: give tension_max"
    with pytest.raises(cdpr.ScenarioError) as caught:
        cdpr.simulate(scenario(solver, math.inf, infeasible=policy))
    assert text in str(caught.value)
    assert cdpr.simulate(scenario(solver, 1e4)).status == "finished"


@pytest.mark.parametrize("solver", ["qp", "lp", "kernel"])
def test_others_do_not(solver):
    assert cdpr.simulate(scenario(solver, math.inf)).status == "finished"


def test_the_status_of_exact():
    robot = cdpr.load_robot("caroca")
    found = cdpr.distribute(robot, robot.home, solver="exact", tension_max=[math.inf] * 8)
    assert found.status == cdpr.tension.Status.UNSUPPORTED
