"""The stage believes no solver and always leaves admissible tensions."""

from __future__ import annotations

import re

import numpy as np
import pytest
from conftest import crossed_box, make_robot
from tension_operations import accept, box_least_squares

from cdpr.base.errors import Diverged, Infeasible, PluginError, SolverFailed
from cdpr.mechanics import kinematics
from cdpr.tension import Status
from cdpr.tension.checks import RESIDUAL_TOLERANCE
from cdpr.tension.current_sample import Present
from cdpr.tension.stage import StageSolver, TensionStage
from cdpr_solvers.options import QpOptions
from cdpr_solvers.qp import MinimumNorm

pytestmark = pytest.mark.core

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
            StageSolver(solve or MinimumNorm(self.robot, QpOptions()).solve, "probe", respects_bounds, policy),
            Present(self.W, self.wrench, self.tension, self.report),
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


def test_answers_that_ignore_limits_are_clipped():
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
    bench.stage.cables.limits[:, 3] = 77.0
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
    bench.stage.cables.limits[:, 3] = answer[3] + 1.0
    assert bench.distribute() == Status.NOT_FOUND


def test_jammed_cables_keep_their_tension_and_the_report_states_it():
    bench = Bench()
    bench.distribute()
    answer = bench.tension.copy()
    bench.stage.impose()  # nothing is held: nothing changes
    np.testing.assert_array_equal(bench.tension, answer)
    bench.stage.cables.held[2] = 0.0
    bench.stage.impose()
    np.testing.assert_array_equal(bench.tension, np.where(np.arange(8) == 2, 0.0, answer))
    scale = np.repeat([1.0, 1.0 / bench.robot.characteristic_length], 3)
    missing = np.linalg.norm(scale * (bench.W @ bench.tension - bench.wrench))
    assert bench.report[0] == Status.OK  # status returned by the solver
    assert bench.report[1] == pytest.approx(missing, rel=1e-9)
    others = np.delete(bench.tension, 2)
    assert bench.report[2] == np.minimum(others - LOW, HIGH - others).min()  # it does not hide theirs


@pytest.mark.parametrize("load", [0.0, 0.1, 50.0, 2e4])
@pytest.mark.parametrize("arm", [0.05, 1.0, 40.0])
def test_the_allowance_is_a_millionth_of_the_load_moments_by_the_length(load, arm):
    """Of the wrench's weighed norm, and of 1 N where that is less; a moment's residual is weighed likewise."""
    W, limits = np.eye(2), np.array([[-1e9, -1e9], [1e9, 1e9]])
    weights = np.array([1.0, 1.0 / arm])
    wrench = np.array([0.6 * load, 0.8 * load * arm])
    for factor, status in ((0.99, Status.OK), (1.01, Status.NOT_FOUND)):
        for off in (np.array([1.0, 0.0]), np.array([0.0, arm])):
            answer = wrench + factor * RESIDUAL_TOLERANCE * max(1.0, load) * off
            assert accept(W, wrench, weights, limits, answer, np.zeros(2), np.zeros(4)) == status


def test_a_solver_finds_the_tensions_that_replaced_its_answer():
    found = []

    def solve(W, wrench, t_min, t_max, tension):
        found.append(tension.copy())
        tension[:] = 77.0
        return Status.NOT_FOUND

    bench = Bench(solve)
    bench.distribute()
    bench.stage.distribute()
    assert np.isnan(found[0]).all()
    np.testing.assert_array_equal(found[1], bench.tension)
    assert not np.array_equal(found[1], np.full(8, 77.0))


def nearest_tensions(W, wrench, high):
    """Best effort from no tension up to `high`, and the steps that it took."""
    W, wrench, high = (np.array(a, dtype=float) for a in (W, wrench, high))
    n, m = W.shape
    tension = np.zeros(m)
    return box_least_squares(W, wrench, np.ones(n), np.zeros(m), high, tension), tension


def test_of_several_nearest_tensions_it_is_the_least():
    """One cable cannot reach its share; of two that share the other, both pull."""
    steps, tension = nearest_tensions([[1, 1, 0], [0, 0, 1]], [8, 30], [10, 10, 10])
    assert steps > 0
    np.testing.assert_allclose(tension, [4, 4, 10], atol=1e-12)


def test_a_cable_that_reached_its_upper_limit_stays_there():
    """It took part, was blocked above, and is not used again: all at the active limit, in a step each."""
    steps, tension = nearest_tensions([[1, 2, 0.5], [0, 1, 1]], [100, 100], [10, 10, 10])
    np.testing.assert_array_equal(tension, [10, 10, 10])
    assert 0 < steps <= 4


def test_a_cable_blocked_at_its_limit_still_pulls():
    """Its contribution is subtracted from that of the others: 6.2 / 1.04 N, by hand."""
    steps, tension = nearest_tensions([[1, 0.5], [0.2, 1]], [10, 16], [100, 10])
    assert steps > 0
    np.testing.assert_allclose(tension, [6.2 / 1.04, 10.0], rtol=1e-14)


@pytest.mark.parametrize("size", [1e3, 1e160, 1e200, 1e307])
def test_absurd_wrenches_are_neither_balanced_nor_infinitely_far(size):
    """Their squares overflow: an infinite residual once was within an infinite allowance."""
    W, wrench = np.array([[1.0, -1.0, 0.5], [0.0, 1.0, 1.0]]), np.array([size, -size])
    limits, report, out = np.array([np.full(3, 1.0), np.full(3, 1e308)]), np.zeros(4), np.zeros(3)
    weak = np.full(3, 10.0)
    assert accept(W, wrench, np.ones(2), limits, weak, out, report) == Status.NOT_FOUND
    assert report[1] == pytest.approx(np.hypot(*(W @ weak / size - wrench / size)) * size)
    exact = np.array([size, 1.0, 1.0])
    assert accept(W, W @ exact, np.ones(2), limits, exact, out, report) == Status.OK
    assert report[1] <= 1e-15 * size


@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e-6, 1e-9])
def test_verdicts_of_small_robots_are_as_strict(unit):
    """A robot that is held by millinewtons has the verdicts of one a thousand times as strong."""
    W = np.ascontiguousarray(Bench().W)
    limits = unit * np.array([np.full(8, 0.02), np.ones(8)])
    right = unit * np.linspace(0.1, 0.9, 8)
    wrench = 1e-3 * W @ right  # a light load between taut cables: it is judged by the floor
    inner = right - np.linalg.lstsq(W, W @ right - wrench, rcond=None)[0]
    assert (limits[0] < inner).all()
    assert (inner < limits[1]).all()

    def verdict(answer):
        report, tension = np.zeros(4), np.zeros(8)
        return accept(W, wrench, np.ones(6), limits, answer, tension, report), report

    assert verdict(inner)[0] == Status.OK
    for wrong in (1e-5, 1e-4):
        off = inner + wrong * unit * np.eye(8)[3]
        assert verdict(off)[0] == Status.NOT_FOUND
    at_rest = np.zeros(6)
    beyond = unit * np.array([*[0.5] * 7, 1.00001])
    assert accept(np.zeros((6, 8)), at_rest, np.ones(6), limits, beyond, np.zeros(8), np.zeros(4)) == Status.NOT_FOUND
    touching = unit * np.array([*[0.5] * 6, 1.0 - 1e-5, 1.0])
    report = np.zeros(4)
    accept(np.zeros((6, 8)), at_rest, np.ones(6), limits, touching, np.zeros(8), report)
    assert report[3] == 1.0


@pytest.mark.parametrize(
    ("answer", "told"),
    [
        ([np.nan, *[100.0] * 7], "not finite: cable_1 nan"),
        ([100.0] * 8, "the tensions miss the wrench by "),
        ([*[100.0] * 7, HIGH + 2.0], "cable_8 is 2 N beyond its limits, 10 to 500 N; allowed: 1e-06 N"),
    ],
)
def test_a_refused_answer_is_reported_once_with_the_check_that_it_failed(answer, told):
    bench = Bench(answering(answer))
    assert bench.distribute() == Status.NOT_FOUND
    assert told in bench.stage.refusal
    bench.wrench += 1.0
    first = bench.stage.refusal
    bench.distribute()
    assert bench.stage.refusal is first
    with pytest.raises(SolverFailed, match=re.escape(told)):
        Bench(answering(answer), policy="stop").distribute()
    assert "beyond" not in refused(answer, respects_bounds=False)


def refused(answer, **more):
    bench = Bench(answering(answer), **more)
    bench.distribute()
    return bench.stage.refusal


def test_an_answer_that_is_just_within_the_wrench_is_not_refused():
    assert refused(np.linspace(50.0, 200.0, 8)) == ""
    miss = np.linspace(50.0, 200.0, 8) + np.eye(8)[0]
    bench = Bench()
    residual = (bench.W @ miss - bench.wrench) / [1, 1, 1, *[bench.robot.characteristic_length] * 3]
    assert f"miss the wrench by {np.linalg.norm(residual):.3g} N" in refused(miss)
