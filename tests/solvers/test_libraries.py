"""Solvers that use a library, against the exact one and on problems that are difficult for libraries."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from test_qp import margin, problem

from cdpr.base.errors import PluginError
from cdpr.plugins.registry import registry
from cdpr.tension import Status
from cdpr_solvers.exact import Exact
from cdpr_solvers.options import ExactOptions, QpsolversOptions

LIMIT = 1e-6  # N: what the tension stage takes for within the limits
BALANCE = 1e-6  # of the load; round-off for those that declare themselves exact
CERTAIN = 1e-3  # N of margin below which a method with a tolerance may err about feasibility


@dataclass(frozen=True)
class Wrapped:
    """A solver, and how far its tensions may be from the optimum, N, with limits up to 500 N."""

    name: str
    optimum: float
    options: dict[str, object]

    def make(self, robot):
        entry = registry().get("solver", self.name)
        return entry.load()(robot, entry.info.options(**self.options))

    @property
    def objective(self):
        return registry().get("solver", self.name).info.properties["objective"]


CLARABEL = {"tol_gap_abs": 1e-13, "tol_gap_rel": 1e-13, "tol_feas": 1e-12}
WRAPPED = [
    Wrapped("osqp", 1e-5, {}),
    Wrapped("daqp", 1e-8, {}),
    Wrapped("piqp", 1e-5, {}),
    Wrapped("clarabel", 1e-5, {}),
    Wrapped("highs", 1e-8, {}),  # in the sum
    Wrapped("qpsolvers", 1e-8, {}),
    Wrapped("qpsolvers", 1e-8, {"name": "quadprog"}),
    Wrapped("qpsolvers", 1e-5, {"name": "clarabel", "settings": CLARABEL}),
]
NAMES = ["osqp", "daqp", "piqp", "clarabel", "highs", "qpsolvers", "quadprog", "sparse"]

wrapped = pytest.mark.parametrize("wrapped", WRAPPED, ids=NAMES)


def call(solver, W, wrench, low, high):
    t = np.full(W.shape[1], np.nan)
    for array in (W, wrench):
        array.flags.writeable = False  # as the tension stage gives them
    return solver.solve(W, wrench, low, high, t), t


def assert_true(W, wrench, low, high, t):
    """The tensions balance the wrench within the limits."""
    assert np.abs(W @ t - wrench).max() <= BALANCE * max(1.0, np.abs(wrench).max())
    assert np.all(t >= low - LIMIT)
    assert np.all(t <= high + LIMIT)


@cache
def problems(m):
    """Problems of one robot's size, feasible and not in turn, with the exact answers for both objectives."""
    cases = []
    for seed in range(36):
        robot, W, wrench = problem(seed, m, [0.0, 60.0, 300.0, 1500.0][seed % 4])
        if seed % 3 == 0:
            wrench = W @ np.random.default_rng(seed).uniform(10.0, 500.0, m)
        low, high = robot.tension_min, robot.tension_max
        answers = {}
        for objective in ("min_norm", "one_norm"):
            answers[objective] = call(Exact(robot, ExactOptions(objective=objective)), W, wrench, low, high)
        cases.append((robot, W, wrench, answers))
    return cases


@wrapped
@pytest.mark.parametrize("m", [4, 6, 8, 12])
@pytest.mark.usual("6-o*", "8-[!o]*")
def test_each_agrees_with_exact_whatever_came_before(wrapped, m):
    """One solver over all problems: an infeasible one leaves nothing behind."""
    solver, statuses = None, set()
    for robot, W, wrench, answers in problems(m):
        solver = solver or wrapped.make(robot)
        low, high = robot.tension_min, robot.tension_max
        status, t = call(solver, W, wrench, low, high)
        truth, best = answers[wrapped.objective]
        statuses.add(status)
        if status == Status.OK:
            assert_true(W, wrench, low, high, t)
        if (status == Status.OK) != (truth == Status.OK):
            # With as many equations as unknowns or more, what was rounded is exactly infeasible.
            assert m <= 6 or abs(margin(W, wrench, low, high)) < CERTAIN
        elif status == Status.OK and wrapped.objective == "one_norm":
            assert t.sum() == pytest.approx(best.sum(), abs=wrapped.optimum)
        elif status == Status.OK:
            assert np.abs(t - best).max() < wrapped.optimum
    told = {Status.OK, Status.INFEASIBLE, Status.NOT_FOUND} if wrapped.name == "qpsolvers" or m == 4 else ()
    assert Status.OK in statuses
    assert statuses <= {Status.OK, Status.INFEASIBLE, *told}
    assert len(statuses) > 1


def odd_problems(m):
    """Name -> (W, wrench, low, high, whether there is an answer)."""
    robot, W, _ = problem(5, m, 0.0)
    n = len(W)
    t = np.linspace(60.0, 200.0, m)
    low, high, zero = robot.tension_min, robot.tension_max, np.zeros(n)
    twin, hollow, flat, same, cut = W.copy(), W.copy(), W.copy(), W.copy(), t.copy()
    twin[:, 1] = twin[:, 0]
    hollow[:, 2] = 0.0
    flat[4] = 0.0
    same[5] = same[4]
    cut[3] = 0.0
    locked = np.arange(m) == 3
    units = np.array([1.0, 1.0, 1e3, 1.0, 1e-4, 1e-3])
    away = np.eye(n)[4]

    def at(value):
        return np.where(locked, value, low), np.where(locked, value, high)

    return {
        "locked cable": (W, W @ t, *at(t), True),
        "cut cable": (W, W @ cut, *at(0.0), True),
        "every cable locked": (W, W @ t, t, t, True),
        "every cable locked, another wrench": (W, W @ t + away, t, t, False),
        "every cable cut": (W, zero, np.zeros(m), np.zeros(m), True),
        "every cable cut, under load": (W, W @ t, np.zeros(m), np.zeros(m), False),
        "no wrench, slack allowed": (W, zero, np.zeros(m), high, True),
        "two equal cables": (twin, twin @ t, low, high, True),
        "a cable without effect": (hollow, hollow @ t, low, high, True),
        "a direction that nothing drives": (flat, flat @ t, low, high, True),
        "the same with a load": (flat, flat @ t + away, low, high, False),
        "equal rows": (same, same @ t, low, high, True),
        "equal rows that contradict": (same, same @ t + away, low, high, False),
        "rows in other units": (units[:, None] * W, units * (W @ t), low, high, True),
        "kilonewtons times a thousand": (W, 1e3 * (W @ t), 1e3 * low, 1e3 * high, True),
        "micronewtons": (W, 1e-6 * (W @ t), 1e-6 * low, 1e-6 * high, True),
        "no matrix": (0.0 * W, zero, low, high, True),
        "no matrix, with a load": (0.0 * W, away, low, high, False),
        "round-off in a row": (
            np.where(np.arange(n)[:, None] == 4, 1e-17, W),
            (W @ t) * (np.arange(n) != 4),
            low,
            high,
            True,
        ),
    }


@wrapped
@pytest.mark.parametrize("m", [4, 6, 9])
@pytest.mark.usual("6-*", "9-q*")
def test_odd_problems_have_defined_outcomes(wrapped, m):
    """Nothing raised, nothing false, and an answer where there is one."""
    for name, (W, wrench, low, high, possible) in odd_problems(m).items():
        robot = problem(5, m, 0.0)[0]
        status, t = call(wrapped.make(robot), W, wrench, low, high)
        if possible:
            assert status == Status.OK, name
            assert_true(W, wrench, low, high, t)
        else:
            assert status in (Status.INFEASIBLE, Status.NOT_FOUND), name


@wrapped
def test_entries_of_w_that_are_zero_at_first_may_change(wrapped):
    """Libraries for sparse matrices keep the pattern of the first."""
    robot, W, _ = problem(3, 8, 0.0)
    solver = wrapped.make(robot)
    hollow = np.where(np.abs(W) > 0.5, W, 0.0)
    for matrix in (hollow, W, hollow, np.asfortranarray(W)):
        wrench = matrix @ np.linspace(60.0, 200.0, 8)
        status, t = call(solver, matrix, wrench, robot.tension_min, robot.tension_max)
        assert status == Status.OK
        assert_true(matrix, wrench, robot.tension_min, robot.tension_max, t)


@wrapped
def test_bad_input_is_reported_and_dropped(wrapped, capfd):
    """The libraries themselves answer, print, hang or keep the previous problem."""
    robot, W, _ = problem(1, 8, 0.0)
    low, high = robot.tension_min, robot.tension_max
    wrench = W @ np.linspace(60.0, 200.0, 8)
    solver = wrapped.make(robot)
    before = call(solver, W, wrench, low, high)
    for bad in (np.nan, np.inf, -np.inf):
        broken, spoilt = W.copy(), low.copy()
        broken[0, 0] = spoilt[3] = bad
        assert call(solver, broken, wrench, low, high)[0] == Status.BAD_INPUT
        assert call(solver, W, wrench * bad, low, high)[0] == Status.BAD_INPUT
        assert call(solver, W, wrench, spoilt, high)[0] == Status.BAD_INPUT
        assert call(solver, W, wrench, low, spoilt)[0] == Status.BAD_INPUT
    assert call(solver, W, wrench, high, low)[0] == Status.BAD_INPUT
    for huge in (1e200, 1.7e308):
        assert call(solver, W, np.full(6, huge), low, high)[0] not in (Status.OK, Status.UNSUPPORTED)
    after = call(solver, W, wrench, low, high)
    assert after[0] == before[0] == Status.OK
    np.testing.assert_allclose(after[1], before[1], atol=1e-5)
    assert capfd.readouterr() == ("", "")


def test_an_answer_outside_the_tolerances_is_not_believed():
    """OSQP as it comes calls solved what is off by 0.1 N."""
    robot, W, _ = problem(2, 8, 0.0)
    loose = Wrapped("qpsolvers", 0.0, {"name": "osqp"}).make(robot)
    rng = np.random.default_rng(0)
    statuses = []
    for _ in range(20):
        wrench = W @ rng.uniform(10.0, 500.0, 8)
        status, t = call(loose, W, wrench, robot.tension_min, robot.tension_max)
        statuses.append(status)
        if status == Status.OK:
            assert_true(W, wrench, robot.tension_min, robot.tension_max, t)
    assert Status.NOT_FOUND in statuses


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"name": "quadprgo"}, r"no solver is named 'quadprgo' .*: name one of .*daqp.*quadprog"),
        ({"name": "daqp", "settings": {"nonsense": 1}}, r"cannot use daqp: .*nonsense"),
        ({"name": "osqp", "settings": {"nonsense": 1}}, r"cannot use osqp: .*nonsense"),
    ],
)
def test_qpsolvers_refuses_what_it_cannot_use(options, text):
    with pytest.raises(PluginError, match=text) as refusal:
        Wrapped("qpsolvers", 0.0, options).make(problem(0, 8, 0.0)[0])
    assert "\n" not in str(refusal.value)


def test_only_known_properties_of_qpsolvers_are_declared():
    entry = registry().get("solver", "qpsolvers")
    for name, exact in (("daqp", True), ("quadprog", True), ("osqp", False), ("highs", False)):
        declared = entry.properties(QpsolversOptions(name=name))
        assert declared["exact"] == exact
        assert (declared["coverage"] == "full") == exact


def test_qpsolvers_is_no_extra_of_ours():
    entry = registry().get("solver", "qpsolvers")
    assert entry.remedy == "pip install qpsolvers"
    assert entry.info.options is QpsolversOptions


def test_highs_prints_nothing(capfd):
    """The library prints a banner when callbacks are registered, which its constructor does."""
    robot, W, _ = problem(1, 8, 0.0)
    solver = Wrapped("highs", 1e-8, {}).make(robot)
    status, _ = call(solver, W, W @ np.full(8, 100.0), robot.tension_min, robot.tension_max)
    assert status == Status.OK
    assert tuple(capfd.readouterr()) == ("", "")
