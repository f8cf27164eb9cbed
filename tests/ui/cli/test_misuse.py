"""Mistakes and concurrent calls of users: reported, not ignored."""

from __future__ import annotations

from threading import Thread

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.analysis.distribution.comparison import describe
from cdpr.plugins import TensionSolver
from cdpr.scenario import load_scenario
from cdpr.tension import Status
from cdpr.tension.problem import Problem
from cdpr.ui.report.text.distributions import no_picture

SCENARIOS = ROOT / "scenarios"
POSE = np.array([0.0, 0.0, 1.2, 1.0, 0.0, 0.0, 0.0])
SHORT = "simulation.duration=0.1"


@pytest.fixture(scope="module")
def robot():
    return cdpr.load_robot(SCENARIOS / "robots" / "caroca.yaml")


@pytest.mark.parametrize("wrong", [[1], [("simulation.duration", 0.1)], [SHORT, None], 5])
def test_invalid_overrides_are_reported(wrong):
    with pytest.raises(cdpr.CdprError, match=r"^overrides: expected .*, got "):
        load_scenario(SCENARIOS / "planar.yaml", overrides=wrong)


def test_overrides_may_come_from_a_generator():
    loaded = load_scenario(SCENARIOS / "planar.yaml", overrides=(text for text in [SHORT]))
    assert loaded.simulation.duration == 0.1


def test_masked_numbers_are_no_numbers(robot):
    with pytest.raises(cdpr.CdprError, match=r"^poses: masked values are not supported"):
        cdpr.distribute(robot, np.ma.array(POSE, mask=[0, 0, 1, 0, 0, 0, 0]))
    whole = cdpr.distribute(robot, np.ma.array(POSE))  # nothing is masked
    np.testing.assert_array_equal(whole.tension, cdpr.distribute(robot, POSE).tension)


@pytest.mark.parametrize("wrong", ["about", [1]])
def test_options_that_are_no_mapping_are_reported(robot, wrong):
    with pytest.raises(cdpr.CdprError, match=r"^options: expected a mapping"):
        cdpr.distribute(robot, POSE, options=wrong)


@pytest.mark.parametrize("wrench", [[1e308] * 6, [1e308, 1e308, 0, 0, 0, 0]])
@pytest.mark.usual("wrench1")
def test_tensions_that_no_number_holds_are_not_admissible(robot, wrench):
    found = cdpr.admissible(robot, POSE, wrench)
    assert not found.feasible
    assert found.margin == -np.inf
    for solver in ("qp", "lp", "maximin", "analytic_centre", "best_effort"):
        status = cdpr.distribute(robot, POSE, wrench, solver=solver).status
        assert status in (Status.INFEASIBLE, Status.NOT_FOUND)
    assert "balance the wrench" in no_picture(describe(Problem(robot, POSE, np.array(wrench)), [], "here", "x"))


class Slow(TensionSolver):
    """Keeps the wrench for a while, as solvers with work space do, and puts it into the tensions."""

    def solve(self, W, wrench, t_min, t_max, tension):
        self.kept = float(wrench[2])
        for _ in range(100):
            pass
        tension[:] = np.linalg.pinv(W) @ wrench * (self.kept / wrench[2])
        return Status.OK


@pytest.mark.slow
def test_threads_that_share_a_solver_do_not_share_answers(robot):
    solver, poses, answers = Slow(robot, None), np.tile(POSE, (2000, 1)), {}

    def ask(load):
        wrench = [0, 0, load, 0, 0, 0]
        answers[load] = cdpr.distribute(robot, poses, wrench, solver=solver).feasible.all()

    threads = [Thread(target=ask, args=(load,)) for load in (1200.0, 1500.0, 1800.0)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == {1200.0: True, 1500.0: True, 1800.0: True}
