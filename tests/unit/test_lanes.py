"""Eight rows side by side: the same bits and statuses as one after the other, whatever stands among them."""

from __future__ import annotations

import math
import operator
from types import SimpleNamespace

import numba
import numpy as np
import pytest
from conftest import ROOT
from hypothesis import given, settings
from hypothesis import strategies as st

import cdpr
from cdpr.distribution import distributions
from cdpr.distribution.adversaries import adversaries, robots
from cdpr.distribution.poison import POISON
from cdpr.model import lanes, rotations
from cdpr.model.jit import kernel
from cdpr.plugins import CompiledSolver
from cdpr.plugins.registry import registry
from cdpr.tension import Status, distribute
from cdpr_solvers.qp import minimum_norm, minimum_norms

WIDTH = lanes.WIDTH
ODD = (0.0, -0.0, 1.0, -3.5, math.inf, -math.inf, math.nan, 5e-324, 1e300, 1e-300)

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="only compiled code has lanes")


def loaded(name):
    return cdpr.load_robot(ROOT / "scenarios" / "robots" / f"{name}.yaml")


@pytest.fixture(scope="module")
def robot():
    return loaded("caroca")


def made(robot, name="qp", **options):
    entry = registry().get("solver", name)
    return entry.make(robot, entry.read_options(options))


def alone(robot, **options):
    """The solver without its kernel for eight."""
    solver = made(robot, **options)
    solver.lanes = None
    return solver


@pytest.fixture
def always(monkeypatch):
    """However few the rows are, they are answered side by side."""
    monkeypatch.setattr(distributions, "MANY", 0)


def poses(robot, count, spread=0.5, seed=0):
    rng = np.random.default_rng(seed)
    home = np.zeros(3) if robot.home is None else np.array(robot.home[:3])
    turns = [rotations.from_rpy(*rng.uniform(-0.2, 0.2, 3)) for _ in range(count)]
    return np.hstack([home + rng.uniform(-spread, spread, (count, 3)), np.reshape(turns, (count, 4))])


def expect_same(found, wanted):
    for name in ("tension", "status", "residual", "margin", "at_limit"):
        assert getattr(found, name).tobytes() == getattr(wanted, name).tobytes(), name


def answered(solver, W, wrench, low, high, rubbish=np.nan):
    """Ask eight problems at once: those that are answered as a list of truth values, and the tensions (8, m)."""
    given = [np.ascontiguousarray(np.moveaxis(array, 0, -1)) for array in (W, wrench, low, high)]
    tension = np.full(given[-1].shape, np.nan)
    found = solver.lanes(*given, tension, solver.parameters, np.full((*solver.work.shape, WIDTH), rubbish))
    return [bool(found >> lane & 1) for lane in range(WIDTH)], np.ascontiguousarray(tension.T)


def expect_as_alone(solver, W, wrench, low, high, rubbish=np.nan):
    """Fail where one of eight is answered otherwise than alone; return how many are answered."""
    found, tension = answered(solver, W, wrench, low, high, rubbish)
    for k in np.flatnonzero(found):
        own = np.full(low.shape[1], np.nan)
        assert solver.solve(W[k], wrench[k], low[k], high[k], own) == Status.OK
        assert own.tobytes() == tension[k].tobytes()
    return sum(found)


@kernel
def arithmetic(a, b, out):
    """One source of all that lanes can do."""
    s = 0.0
    for i in range(2):
        s += a[0] * b[0] - a[0] / b[0] + i
        s -= 0.5 * b[0]
    out[0] = s
    out[1] = math.sqrt(abs(a[0])) + -b[0]
    out[2], out[3], out[4] = max(a[0], b[0]), min(a[0], b[0]), max(1.0, a[0], b[0])
    less, same = (a[0] < b[0]) & (a[0] <= b[0]), (a[0] == b[0]) | (a[0] != a[0])
    out[5], out[6] = lanes.choose(less, a[0], 2.0), lanes.choose(same, 1, b[0])
    out[7] = lanes.choose((a[0] > b[0]) | (a[0] >= b[0]), 1.0, 0.0)


@kernel
def arithmetic_of_eight(a, b, out):
    arithmetic(lanes.side_by_side(a), lanes.side_by_side(b), lanes.side_by_side(out))


@kernel
def words(a, out):
    x = lanes.side_by_side(a)
    out[0], out[1] = lanes.some(x[0] > 2.0), lanes.every(x[0] > 2.0)
    out[2], out[3] = lanes.bits(x[0] > 2.0), lanes.whole(x[0])
    out[4] = lanes.bits(~(x[0] > 2.0))


def test_eight_numbers_are_what_each_is_alone():
    pairs = np.array([(a, b) for a in ODD for b in ODD])
    pairs = np.vstack([pairs, pairs[: -len(pairs) % WIDTH]])
    for eight in pairs.reshape(-1, WIDTH, 2):
        found = np.empty((8, WIDTH))
        arithmetic_of_eight(eight[:, :1].T.copy(), eight[:, 1:].T.copy(), found)
        for lane, (a, b) in enumerate(eight):
            out = np.empty(8)
            arithmetic(np.array([a]), np.array([b]), out)
            np.testing.assert_array_equal(found[:, lane], out, strict=True)
            finite = ~np.isnan(out)
            np.testing.assert_array_equal(np.signbit(found[finite, lane]), np.signbit(out[finite]))


@pytest.mark.parametrize("above", [0, 3, 8])
def test_words_ask_any_and_all_of_eight(above):
    out = np.empty(5)
    words(np.where(np.arange(WIDTH) < above, 3.0, 1.0)[None], out)
    rest = 2**WIDTH - 2**above
    assert out.tolist() == [above > 0, above == WIDTH, 2**above - 1, 3.0 if above else 1.0, rest]


def test_words_of_one_number():
    assert lanes.some(True)
    assert not lanes.every(False)
    assert lanes.choose(False, 1.0, 2.0) == 2.0
    assert lanes.whole(3.0) == 3


@pytest.mark.parametrize("name", ["caroca", "planar", "point_mass", "seven", "crossed", "twelve"])
@pytest.mark.parametrize("wrenches", [False, True])
@pytest.mark.usual("True-planar", "True-twelve")
def test_rows_have_the_same_bits(always, name, wrenches):
    robot = loaded(name)
    at = poses(robot, 300)
    wrench = None
    if wrenches:
        rng = np.random.default_rng(1)
        wrench = rng.normal(size=(300, 6)) * rng.choice([10.0, 1e3, 1e5], (300, 1)) + [0, 0, 500.0, 0, 0, 0]
    wanted = distribute(robot, at, wrench, solver=alone(robot))
    expect_same(distribute(robot, at, wrench), wanted)
    expect_same(distribute(robot, np.asfortranarray(at), wrench, jobs=2), wanted)


@kernel
def refusing(W, wrench, t_min, t_max, tension, parameters, work):
    return 2


def test_most_rows_are_answered_side_by_side(robot, always):
    """Else all of these tests would compare one kernel with itself."""
    solver = made(robot)
    solver.kernel = refusing
    status = distribute(robot, poses(robot, 800), solver=solver).status
    assert (status == Status.OK).mean() > 0.9
    assert (distribute(robot, poses(robot, 7), solver=solver).status == Status.NOT_FOUND).all()


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 16, 23])
@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.usual("1-*", "2-23")
def test_any_number_of_rows(robot, always, count, jobs):
    at = poses(robot, count)
    expect_same(distribute(robot, at, jobs=jobs), distribute(robot, at, solver=alone(robot)))


@pytest.mark.slow
def test_several_chunks_in_threads(robot, always):
    at = np.tile(poses(robot, 500), (20, 1))
    wanted = distribute(robot, at, solver=alone(robot), jobs=1)
    for jobs in (1, 3):
        expect_same(distribute(robot, at, jobs=jobs), wanted)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 1.0])
@pytest.mark.usual("0.1", "1.0")
def test_rows_at_limits_and_odd_ones_among_others(robot, always, share):
    """Where a row leaves the common way, neither it nor its neighbours notice who has answered."""
    count = 400
    rng = np.random.default_rng(int(10 * share))
    at, odd = poses(robot, count), rng.random(count) < share
    low = np.full((count, robot.m), 50.0)
    high = np.full((count, robot.m), 1e4)
    wrench = np.tile([10.0, -5.0, 1500.0, 1.0, 2.0, 3.0], (count, 1))
    for k in np.flatnonzero(odd):
        kind = rng.integers(8)
        i = rng.integers(robot.m)
        if kind == 0:
            low[k] = 400.0  # limits become active
        elif kind == 1:
            low[k, i] = high[k, i] = rng.choice([0.0, 120.0])  # cut or locked
        elif kind == 2:
            low[k, i], high[k, i] = 100.0, 60.0  # contradictory
        elif kind == 3:
            high[k, i] = np.nan
        elif kind == 4:
            wrench[k, rng.integers(6)] = rng.choice([np.nan, np.inf, -np.inf, 1e300])
        elif kind == 5:
            at[k, rng.integers(3)] = rng.choice([np.nan, np.inf, 1e200])
        elif kind == 6:
            high[k] = np.inf
        else:
            wrench[k] = 0.0
    arguments = {"tension_min": low, "tension_max": high}
    expect_same(
        distribute(robot, at, wrench, **arguments), distribute(robot, at, wrench, solver=alone(robot), **arguments)
    )


@pytest.mark.parametrize("robot", robots(), ids=lambda robot: f"{robot.n}-{robot.m}")
@pytest.mark.usual("6-8", "2-3", "6-14")
def test_misleading_problems_are_answered_as_alone(robot):
    solver = made(robot)
    problems = adversaries(robot, 400, 11)
    if solver.lanes is None:  # Newton's method on the rows takes these
        assert robot.m > 2 * robot.n
        return
    count = 0
    for k in range(0, 400, WIDTH):
        W, wrench, low, high = (
            array[k : k + WIDTH] for array in (problems.W, problems.wrench, problems.low, problems.high)
        )
        rubbish = POISON[k // WIDTH % 3]
        expect_as_alone(solver, W, wrench, low, high, rubbish)
        # Those limits hold nearly all of them up.
        wide = np.where(low < high, np.inf, high)
        count += expect_as_alone(solver, W, wrench, np.where(low < high, -np.inf, low), wide, rubbish)
    assert count > 50


ENTRY = st.one_of(st.integers(-3, 3).map(float), st.sampled_from(ODD), st.floats(-2.0, 2.0))


@st.composite
def eights(draw):
    """Eight problems of one size, of small whole numbers or any, some odd: ties of pivots, equal and null rows."""
    n, m = draw(st.sampled_from([(1, 2), (2, 3), (3, 4), (3, 5), (6, 7), (6, 8)]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    W = rng.integers(-3, 4, (WIDTH, n, m)).astype(float)
    smooth = rng.random(WIDTH) < 0.5
    W[smooth] = rng.normal(size=(smooth.sum(), n, m))
    t = rng.uniform(1.0, 9.0, (WIDTH, m))
    wrench = np.einsum("kji,ki->kj", W, t)
    low, high = np.zeros((WIDTH, m)), np.full((WIDTH, m), draw(st.sampled_from([10.0, 100.0, math.inf])))
    low -= draw(st.sampled_from([0.0, 0.0, 50.0]))
    scale = 10.0 ** draw(st.sampled_from([0, 0, 0, -200, -160, 150, 300]))
    W, wrench = W * scale, wrench * scale
    for array in (W, wrench, low, high):
        for _ in range(draw(st.integers(0, 2))):
            array.ravel()[draw(st.integers(0, array.size - 1))] = draw(ENTRY)
    return n, m, W, wrench, low, high


@pytest.mark.slow
def test_any_eight_are_answered_as_alone():
    counts = []

    @settings(max_examples=400, deadline=None, derandomize=True)
    @given(eights(), st.sampled_from(POISON))
    def answer(problems, rubbish):
        n, m, *eight = problems
        solver = CompiledSolver(
            SimpleNamespace(n=n, m=m),
            None,
            minimum_norm,
            lanes=minimum_norms,
            parameters=[0.0, math.inf, 0.0, 0.0, *[0.0] * m, *[1.0] * m],
            rows=3 * (n + m) + 60,
        )
        counts.append(expect_as_alone(solver, *eight, rubbish))

    answer()
    assert sum(counts) > len(counts)  # else it would say nothing


def test_what_is_made_for_another_robot_answers_none(robot):
    solver = made(robot)
    W = np.random.default_rng(0).normal(size=(WIDTH, 6, 8))
    limits = np.zeros((WIDTH, 8)), np.full((WIDTH, 8), 10.0)
    solver.work = solver.work[:5]
    assert answered(solver, W, W.sum(axis=2), *limits)[0] == [False] * WIDTH


@pytest.mark.parametrize("options", [{"about": "middle"}, {"weights": [2.0] * 8}])
def test_options_that_ask_for_more_are_left_to_the_other_kernel(robot, options):
    solver = made(robot, **options)
    solver.lanes = minimum_norms
    W = np.random.default_rng(0).normal(size=(WIDTH, 6, 8))
    limits = np.zeros((WIDTH, 8)), np.full((WIDTH, 8), 10.0)
    assert expect_as_alone(solver, W, W.sum(axis=2), *limits) == 0


@pytest.mark.parametrize(
    ("options", "there"),
    [
        ({}, True),
        ({"about": "previous"}, True),
        ({"change": 10.0}, True),
        ({"about": "middle"}, False),
        ({"weights": [1.0] * 8}, False),
    ],
)
@pytest.mark.usual("options1-*", "options3-*")
def test_options_that_have_lanes_change_no_bit(robot, always, options, there):
    at = poses(robot, 100)
    assert (made(robot, **options).lanes is not None) == there
    wanted = distribute(robot, at, solver=alone(robot, **options))
    expect_same(distribute(robot, at, options=options), wanted)


@kernel
def lying(W, wrench, t_min, t_max, tension, parameters, work):
    """It says that it has answered all, and has written the lowest tensions."""
    for i in range(tension.shape[0]):
        for lane in range(tension.shape[1]):
            tension[i, lane] = t_min[i, lane]
    return 255


def test_a_kernel_for_eight_is_not_believed(robot, always):
    at = poses(robot, 40)
    solver = made(robot)
    solver.lanes = lying
    expect_same(distribute(robot, at, solver=solver), distribute(robot, at, solver=alone(robot)))


def test_few_rows_and_cables_over_pulleys_need_no_lanes(robot, monkeypatch):
    """Nothing is compiled, nor read from disk, where that does not pay, or where lanes cannot follow."""

    def never(name):
        raise AssertionError(name)

    monkeypatch.setattr(distributions, "import_module", never)
    distribute(robot, poses(robot, 50))
    monkeypatch.setattr(distributions, "MANY", 0)
    with pytest.raises(AssertionError, match="side_by_side"):
        distribute(robot, poses(robot, 50))
    pulleys = loaded("cogiro_pulleys")
    distribute(pulleys, poses(pulleys, 20, 0.1))
    distribute(robot, poses(robot, 20), solver="lp")


def test_operators_of_another_kind_stay_refused():
    @kernel
    def power(a):
        x = lanes.side_by_side(a)
        return lanes.bits(operator.pow(x[0], 2.0) > 1.0)

    with pytest.raises(numba.TypingError):
        power(np.ones((1, WIDTH)))
