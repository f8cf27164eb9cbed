"""The stage believes no solver and always leaves admissible tensions."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import crossed_box, make_robot

from cdpr.errors import Diverged, Infeasible, PluginError
from cdpr.model import kinematics
from cdpr.tension import Status
from cdpr.tension.stage import TensionStage
from cdpr_solvers.options import QpOptions
from cdpr_solvers.qp import MinimumNorm

LOW, HIGH = 10.0, 500.0


class Bench:
    """A stage around a solver function, with its arrays at hand."""

    def __init__(self, solve=None, *, policy="best_effort", respects_bounds=True):
        self.robot = make_robot(crossed_box(np.random.default_rng(0), 8), limits=(LOW, HIGH))
        self.W = kinematics.wrench_matrix(self.robot, kinematics.make_state([0, 0, 2.0]))
        self.wrench = self.W @ np.linspace(50.0, 200.0, 8)
        self.tension = np.zeros(8)
        self.report = np.full(4, np.nan)
        self.stage = TensionStage(
            self.robot,
            solve or MinimumNorm(self.robot, QpOptions()).solve,
            "probe",
            respects_bounds,
            policy,
            self.W,
            self.wrench,
            self.tension,
            self.report,
        )

    def distribute(self) -> Status:
        self.stage.distribute()
        assert np.all(self.tension >= LOW)
        assert np.all(self.tension <= HIGH)
        return Status(int(self.report[0]))


def answering(values, status=Status.OK):
    def solve(W, wrench, t_min, t_max, tension):
        tension[:] = values
        return status

    return solve


def test_a_good_answer_passes_with_its_report():
    bench = Bench()
    assert bench.distribute() == Status.OK
    np.testing.assert_allclose(bench.W @ bench.tension, bench.wrench, atol=1e-9)
    assert bench.report[1] == pytest.approx(0.0, abs=1e-9)
    assert bench.report[2] == pytest.approx(np.minimum(bench.tension - LOW, HIGH - bench.tension).min())
    assert bench.report[3] == np.count_nonzero(bench.tension == LOW)


@pytest.mark.parametrize(
    "lie", [np.full(8, np.nan), np.full(8, np.inf), np.full(8, 100.0), np.full(8, -50.0), np.full(8, 1e6)]
)
def test_a_false_ok_is_found_and_replaced(lie):
    bench = Bench(answering(lie))
    assert bench.distribute() == Status.NOT_FOUND
    assert bench.report[1] < 1e-3  # best effort reached the feasible wrench


def test_an_answer_just_outside_is_clipped_not_refused():
    bench = Bench()
    bench.distribute()
    answer = bench.tension.copy()
    at_limit = answer == LOW
    assert at_limit.any()
    answer[at_limit] -= 5e-7
    again = Bench(answering(answer))
    assert again.distribute() == Status.OK


@pytest.mark.parametrize("status", [Status.INFEASIBLE, Status.NOT_FOUND, Status.UNSUPPORTED, Status.BAD_INPUT])
def test_each_status_is_recorded_as_given(status):
    assert Bench(answering(np.nan, status)).distribute() == status


def test_policies_on_an_infeasible_wrench():
    best, hold, stop = (Bench(policy=policy) for policy in ("best_effort", "hold_tension", "stop"))
    for bench in (best, hold, stop):
        bench.distribute()
        bench.wrench[2] += 1e5
    before = hold.tension.copy()
    assert best.distribute() == hold.distribute() == Status.INFEASIBLE
    np.testing.assert_array_equal(hold.tension, before)
    assert best.report[1] < hold.report[1]
    assert best.report[1] == pytest.approx(
        np.linalg.norm((best.W @ best.tension - best.wrench) / np.repeat([1, best.robot.characteristic_length], 3))
    )
    with pytest.raises(Infeasible, match="no tensions within the limits"):
        stop.distribute()


def test_who_ignores_limits_is_clipped():
    answer = np.array([-5.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 900.0])
    bench = Bench(answering(answer), respects_bounds=False)
    assert bench.distribute() == Status.NOT_FOUND
    np.testing.assert_array_equal(bench.tension, np.clip(answer, LOW, HIGH))
    assert bench.report[1] > 1.0


def test_a_wrench_that_is_not_finite_stops_the_run():
    bench = Bench()
    bench.wrench[4] = np.nan
    with pytest.raises(Diverged, match="not finite"):
        bench.distribute()


def raising(W, wrench, t_min, t_max, tension):
    raise ZeroDivisionError("oops")


@pytest.mark.parametrize(
    ("solve", "text"),
    [
        (raising, "solver 'probe' raised ZeroDivisionError: oops"),
        (lambda *_: None, "returned None"),
        (lambda *_: 77, "returned 77"),
    ],
)
def test_a_broken_solver_is_named(solve, text):
    with pytest.raises(PluginError, match=text):
        Bench(solve).distribute()


def test_a_solver_cannot_reach_the_recorded_tensions():
    kept = []

    def keep(W, wrench, t_min, t_max, tension):
        kept.append(tension)
        return MinimumNorm(bench.robot, QpOptions()).solve(W, wrench, t_min, t_max, tension)

    bench = Bench(keep)
    bench.distribute()
    before = bench.tension.copy()
    kept[0][:] = 0.0
    np.testing.assert_array_equal(bench.tension, before)


def test_limits_are_live_and_a_locked_cable_has_no_room_to_lose():
    bench = Bench()
    bench.distribute()
    bench.stage.limits[:, 3] = 77.0
    bench.distribute()
    assert bench.tension[3] == 77.0
    np.testing.assert_allclose(bench.W @ bench.tension, bench.wrench, atol=1e-9)
    others = np.delete(bench.tension, 3)
    assert bench.report[2] == pytest.approx(np.minimum(others - LOW, HIGH - others).min(), abs=1e-9)
    assert bench.report[3] == np.count_nonzero(others == LOW)


def test_an_answer_that_moves_a_locked_cable_is_refused():
    bench = Bench()
    bench.distribute()
    answer = bench.tension.copy()
    bench = Bench(answering(answer))
    bench.stage.limits[:, 3] = answer[3] + 1.0
    assert bench.distribute() == Status.NOT_FOUND


def test_held_cables_pull_what_they_pull_and_the_report_says_so():
    bench = Bench()
    bench.distribute()
    answer = bench.tension.copy()
    bench.stage.impose()  # nothing is held: nothing changes
    np.testing.assert_array_equal(bench.tension, answer)
    bench.stage.held[2] = 0.0
    bench.stage.impose()
    np.testing.assert_array_equal(bench.tension, np.where(np.arange(8) == 2, 0.0, answer))
    scale = np.repeat([1.0, 1.0 / bench.robot.characteristic_length], 3)
    missing = np.linalg.norm(scale * (bench.W @ bench.tension - bench.wrench))
    assert bench.report[0] == Status.OK  # what the solver said of its answer
    assert bench.report[1] == pytest.approx(missing, rel=1e-9)
    others = np.delete(bench.tension, 2)
    assert bench.report[2] == np.minimum(others - LOW, HIGH - others).min()  # it does not hide theirs
