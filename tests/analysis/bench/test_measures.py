"""Each figure of the benchmark, on solvers that misbehave in exactly that way."""

from __future__ import annotations

import json
from unittest import mock

import bench_cases as cases
import numpy as np
import pytest
from bench_cases import plugin, plugins, wall
from spread import sampled

from cdpr.analysis.bench import benchmark, measures, oracle, run
from cdpr.analysis.bench.continuity import steepest
from cdpr.analysis.bench.measures import jumps
from cdpr.analysis.bench.overview import overview
from cdpr.analysis.bench.problems import make_paths, make_problems
from cdpr.base.errors import CdprError, PluginError
from cdpr.plugins import PluginInfo
from cdpr.plugins.registry import registry
from cdpr_solvers.qp import MinimumNorm

POSES = 50


@pytest.fixture(scope="module", autouse=True)
def _asked_once():
    """Each set of problems is decided once, by hundreds of linear programs, whoever is measured on it."""
    known = {}

    def consult(problems, objectives=()):
        asked = (problems.robot.name, problems.W.tobytes(), problems.wrench.tobytes(), *objectives)
        if asked not in known:
            known[asked] = oracle.consult(problems, objectives)
        return known[asked]

    with mock.patch.object(benchmark, "consult", consult):
        yield


@pytest.fixture
def no_paths(monkeypatch):
    """For figures that depend on poses only; a path takes 400 calls."""
    none = {"paths": 0, "with_jump": 0, "largest_N": None}
    monkeypatch.setattr(measures, "jumps", lambda paths, answer: none)


def measured(solver, poses=POSES, **properties):
    (row,) = run([wall()], None, poses, plugins=plugins(plugin(solver, **properties)))["robots"][0]["results"]
    return row


def test_a_sound_solver():
    row = measured(MinimumNorm, objective="min_norm")
    assert row["outcome"] == "measured"
    assert row["coverage"] == 1.0
    assert row["misclassified"] == row["invalid_ok"] == 0
    assert row["worst_residual"] < 1e-13
    assert row["worst_violation_N"] == 0.0
    assert row["gap"] < 1e-12
    assert row["jumps"] == {"paths": 1, "with_jump": 0, "largest_N": None}
    assert row["on_feasible"] == {"OK": 1.0}
    assert row["on_infeasible"] == {"INFEASIBLE": 1.0}
    assert row["feasible"] + row["infeasible"] == POSES
    assert row["feasible"] > 20
    assert row["infeasible"] > 5


@pytest.mark.usefixtures("no_paths")
def test_wrong_ok():
    row = measured(cases.AlwaysOk)
    assert row["misclassified"] == row["invalid_ok"] == row["infeasible"]
    assert row["coverage"] == 1.0
    assert row["on_infeasible"] == {"OK": 1.0}


@pytest.mark.usefixtures("no_paths")
def test_a_solver_declared_to_ignore_limits_is_not_wrong_but_covers_less():
    row = measured(cases.PseudoInverse, respects_bounds=False)
    assert row["misclassified"] == 0
    assert row["coverage"] < 0.5
    assert row["invalid_ok"] > row["infeasible"]
    assert row["worst_residual"] < 1e-13


@pytest.mark.usefixtures("no_paths")
def test_bound_violation():
    row = measured(cases.PseudoInverse)
    assert row["misclassified"] == row["infeasible"]
    problems = make_problems(wall(), POSES, 1)
    t = np.array([np.linalg.pinv(W) @ w for W, w in zip(problems.W, problems.wrench, strict=True)])
    assert row["worst_violation_N"] == pytest.approx(max(5.0 - t.min(), t.max() - 300.0))


def test_feasible_called_infeasible():
    row = measured(cases.NeverFeasible)
    assert row["misclassified"] == row["feasible"]
    assert row["coverage"] == 0.0
    assert row["invalid_ok"] == 0
    assert row["worst_residual"] is None
    assert row["jumps"]["paths"] == 0


@pytest.mark.usefixtures("no_paths")
def test_residual():
    row = measured(cases.Unbalanced)
    assert row["coverage"] == 0.0
    assert row["invalid_ok"] == row["feasible"]
    assert 1e-4 < row["worst_residual"] < 1e-2


def test_ok_with_nothing_written():
    row = measured(cases.NotWritten)
    assert row["coverage"] == 0.0
    assert row["invalid_ok"] == POSES
    assert row["worst_residual"] is None
    assert row["gap"] is None


@pytest.mark.slow
@pytest.mark.usefixtures("no_paths")
def test_gap_of_a_suboptimal_solver():
    best = measured(MinimumNorm, objective="min_norm")
    row = measured(cases.Suboptimal, objective="min_norm")
    assert row["coverage"] == best["coverage"] == 1.0
    assert 1e-4 < row["gap"] < 1e-2  # a hundredth of a distance that the limits bound
    assert measured(MinimumNorm)["gap"] is None  # nothing declared
    assert measured(MinimumNorm, objective="centroid")["gap"] is None


@pytest.mark.slow
@pytest.mark.usefixtures("no_paths")
@sampled(
    1,
    ("objective", "best", "other"),
    [("one_norm", cases.LeastSum, cases.Roomiest), ("max_slack", cases.Roomiest, cases.LeastSum)],
)
def test_gap_of_linear_programs_is_one_of_cost(objective, best, other):
    assert abs(measured(best, objective=objective)["gap"]) < 1e-8
    assert measured(other, objective=objective)["gap"] > 0.01


@pytest.mark.slow
def test_jump():
    both = plugins(plugin(cases.Jumping, "jumping"), plugin(MinimumNorm, "sound"))
    row, sound = run([wall()], None, 300, plugins=both)["robots"][0]["results"]
    assert row["jumps"]["paths"] == 6
    assert 0 < row["jumps"]["with_jump"] < 6
    assert row["jumps"]["largest_N"] == pytest.approx(3.0, abs=1e-4)
    assert sound["jumps"] == {"paths": 6, "with_jump": 0, "largest_N": None}


PATHS = make_paths(wall(), 1, 1)


@pytest.mark.parametrize(
    ("curve", "jump"),
    [
        (lambda s: 5.0 * (s > 0.37123), 5.0),
        (lambda s: 80.0 * s + 0.7 * (s > 0.5), 0.7),
        (lambda s: 80.0 * np.tanh(1e4 * (s - 0.5001)), None),  # steep, but smooth
        (lambda s: 80.0 * abs(s - 0.3) ** 0.8, None),  # a kink, with infinite slope
        (lambda s: 1e-3 * np.sin(1e9 * s), None),  # an iterative solver's noise
    ],
)
def test_jumps_are_distinguished_from_steep_curves(curve, jump):
    found = jumps(PATHS, lambda path, s: np.array([100.0, curve(s), 50.0, 0.0]))
    assert found == {"paths": 1, "with_jump": int(jump is not None), "largest_N": jump and pytest.approx(jump)}


def test_a_path_that_is_hardly_answered_does_not_count():
    assert jumps(PATHS, lambda path, s: np.zeros(4) if s < 0.4 else None)["paths"] == 0
    assert jumps(PATHS, lambda path, s: np.zeros(4) if s < 0.6 else None) == {
        "paths": 1,
        "with_jump": 0,
        "largest_N": None,
    }


def test_the_second_steepest_place_may_be_the_one_that_jumps():
    def curve(s):
        return np.array([30.0 * np.tanh(1e3 * (s - 0.25)) + 9.0 * (s > 0.75)])

    assert steepest(curve, 100, 26, places=1).change < 1e-3
    assert steepest(curve, 100, 26, places=3).change == pytest.approx(9.0)


@pytest.mark.usefixtures("no_paths")
@pytest.mark.parametrize(
    ("solver", "text"),
    [
        (cases.Raising, "raised ZeroDivisionError: division by zero at problem 5"),
        (cases.Leaving, "raised SystemExit: bye"),
        (cases.NotMade, "raised ValueError: no such robot during construction"),
        (cases.NoStatus, "returned 17, which is not a cdpr.tension.Status"),
        (cases.Vandal, "raised ValueError: assignment destination is read-only"),
    ],
)
def test_a_broken_solver_is_a_row_with_its_error(solver, text):
    found = run([wall()], None, 30, plugins=plugins(plugin(solver), plugin(MinimumNorm, "sound")))
    broken, sound = found["robots"][0]["results"]
    assert broken == {"solver": "fake", "outcome": "failed", "detail": text}
    assert sound["outcome"] == "measured"
    assert overview(found)[0]["failed"] == 1


def test_unsupported():
    assert measured(cases.Unsupporting) == {"solver": "fake", "outcome": "unsupported", "detail": ""}


@pytest.mark.usefixtures("no_paths")
def test_a_solver_that_is_not_installed_is_listed_with_its_remedy():
    missing = PluginInfo("absent", "absent:Absent", "", requires=("no_such_package",), extra="cdpr[none]")
    found = run([wall()], None, 20, plugins=plugins(missing, plugin(MinimumNorm)))
    assert [row["solver"] for row in found["robots"][0]["results"]] == ["fake"]
    assert found["solvers"][0]["problem"] == (
        "solver 'absent' needs no_such_package, which is not installed: pip install 'cdpr[none]'"
    )
    assert overview(found)[0]["coverage"] is None


@pytest.mark.usefixtures("no_paths")
def test_times():
    time = measured(cases.Sleeping, poses=20)["time"]
    assert time["median_us"] >= 2000.0
    assert time["p99_us"] >= time["median_us"]
    assert time["infeasible_median_us"] >= 2000.0
    assert time["median_pinv"] == pytest.approx(time["median_us"] / time["pinv_us"])


@pytest.mark.slow
def test_slow_solvers_get_the_first_problems_only():
    row = measured(MinimumNorm, poses=600, slow=True)
    assert row["problems"] == 12
    assert row["feasible"] + row["infeasible"] == 12
    assert row["jumps"]["paths"] == 1
    assert measured(MinimumNorm, poses=60, slow=True)["problems"] == 10
    assert measured(MinimumNorm, poses=4, slow=True)["problems"] == 4


@pytest.mark.slow
def test_all_but_the_times_is_the_same_each_time(monkeypatch):
    monkeypatch.setattr(measures, "STEPS", 30)  # of a path: what differs by chance does so at any point

    def figures():
        found = run([wall(), cases.carriage()], None, 3, 7)
        for robot in found["robots"]:
            for row in robot["results"]:
                if row["outcome"] == "measured":
                    assert row.pop("time")["median_us"] > 0.0
        return json.dumps(found, allow_nan=False)

    assert figures() == figures()


@pytest.mark.usefixtures("no_paths")
def test_an_interrupt_keeps_what_is_complete():
    solvers = plugins(plugin(MinimumNorm, "a"), plugin(cases.Interrupted, "b"), plugin(MinimumNorm, "c"))
    found = run([wall(), cases.carriage()], None, 20, plugins=solvers)
    assert found["interrupted"] is True
    (robot,) = found["robots"]
    assert [row["solver"] for row in robot["results"]] == ["a"]


@pytest.mark.usefixtures("no_paths")
def test_progress_ends_at_its_total():
    calls = []
    run([wall(), wall()], ["qp", "closed_form"], 5, progress=lambda *step: calls.append(step))
    assert calls[0] == (0, 10)
    assert calls[-1] == (10, 10)
    assert calls == sorted(calls)


@pytest.mark.slow
@pytest.mark.usefixtures("no_paths")
def test_every_installed_solver_is_used_by_default():
    assert [row["name"] for row in run([wall()], None, 2)["solvers"]] == registry().names("solver")
    assert [row["name"] for row in run([wall()], ["qp"], 2)["solvers"]] == ["qp"]


def test_wrong_arguments():
    with pytest.raises(PluginError, match="did you mean 'qp'"):
        run([wall()], ["qpp"], 2)
    for robots, solvers, poses in (([], None, 2), ([wall()], [], 2), ([wall()], None, 0)):
        with pytest.raises(CdprError, match="at least one"):
            run(robots, solvers, poses)


@pytest.mark.usefixtures("no_paths")
def test_declarations_of_third_parties_are_escaped():
    found = run([wall()], None, 2, plugins=plugins(plugin(MinimumNorm, colour={1, 2}, exact=True)))
    assert found["solvers"][0]["properties"] == {"colour": "{1, 2}", "exact": True}
    json.dumps(found, allow_nan=False)


@pytest.mark.slow
def test_overview_goes_from_the_worst_to_the_best():
    found = run([wall(), cases.carriage()], ["closed_form", "qp"], 100)
    closed, exact = overview(found)
    assert closed["coverage"][0] < closed["coverage"][1] == 1.0
    assert exact["coverage"] == (1.0, 1.0)
    assert exact["redundancy"] == (1, 2)
    assert exact["paths"] == 4
    assert exact["infeasible_detected"] == 1.0
    assert 0.5 < closed["infeasible_detected"] < 1.0  # those that a ball around the middle of the limits proves
    assert exact["median_pinv"][0] <= exact["median_pinv"][1]
