"""Eight rows in parallel: the same bits and statuses as one after the other, for any neighbours."""

from __future__ import annotations

import ctypes
import math
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import ROOT
from hypothesis import given, settings
from hypothesis import strategies as st

import cdpr
from cdpr import distribute
from cdpr.analysis.bench.adversaries import adversaries, robots
from cdpr.analysis.bench.poison import POISON
from cdpr.analysis.distribution import distributions
from cdpr.model import rotations
from cdpr.native.bind import LANES as WIDTH
from cdpr.native.foreign import OPERATION, Foreign
from cdpr.plugins.registry import registry
from cdpr.tension import Status
from cdpr_solvers.options import QpOptions
from cdpr_solvers.qp import MinimumNorm

ODD = (0.0, -0.0, 1.0, -3.5, math.inf, -math.inf, math.nan, 5e-324, 1e300, 1e-300)


def loaded(name):
    return cdpr.load_robot(ROOT / "scenarios" / "robots" / f"{name}.yaml")


@pytest.fixture(scope="module")
def robot():
    return loaded("caroca")


def made(robot, name="qp", **options):
    entry = registry().get("solver", name)
    return entry.make(robot, entry.read_options(options))


def alone(robot, name="qp", **options):
    """The solver without its operation for eight."""
    solver = made(robot, name, **options)
    solver.side_by_side = lambda *arrays: None
    return solver


def by_python(function):
    """An operation that calls a Python function."""
    call = OPERATION(function)
    return Foreign(SimpleNamespace(address=ctypes.cast(call, ctypes.c_void_p).value, call=call))


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


def expect_as_alone(solver, W, wrench, low, high, rubbish=np.nan):
    """Fail where one of eight is answered otherwise than alone; return how many have an answer."""
    given = [np.ascontiguousarray(np.moveaxis(array, 0, -1)) for array in (W, wrench, low, high)]
    tension = np.full(given[-1].shape, np.nan)
    call = solver.side_by_side(*given, tension)
    used = {id(call.given[name]) for name in call.given if name != "status"}
    for array in call.arrays:
        if id(array) not in used:
            array[...] = rubbish
    refused = call()
    for k in range(WIDTH):
        own = np.full(low.shape[1], np.nan)
        status = solver.solve(W[k], wrench[k], low[k], high[k], own)
        assert (status != Status.OK) == bool(refused >> k & 1)
        if status == Status.OK:
            assert own.tobytes() == np.ascontiguousarray(tension[:, k]).tobytes()
    return WIDTH - refused.bit_count()


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


class Refusing(MinimumNorm):
    """It has answers for eight at once only."""

    def compiled(self, W, wrench, t_min, t_max, tension):
        return by_python(lambda place, time: Status.NOT_FOUND)


def test_most_rows_are_answered_side_by_side(robot, always):
    """Else all of these tests would compare one operation with itself."""
    solver = Refusing(robot, QpOptions())
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
    """If a row leaves the common path, its result and those of its neighbours are unchanged."""
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
        solver = MinimumNorm(SimpleNamespace(n=n, m=m), QpOptions())
        counts.append(expect_as_alone(solver, *eight, rubbish))

    answer()
    assert sum(counts) > len(counts)  # otherwise the test would prove nothing


@pytest.mark.parametrize(
    "options", [{"about": "previous"}, {"change": 10.0}, {"about": "middle"}, {"weights": [1.0, 2.0] * 4}]
)
@pytest.mark.usual("options1", "options3")
def test_options_change_no_bit(robot, always, options):
    at = poses(robot, 100)
    wanted = distribute(robot, at, solver=alone(robot, **options))
    expect_same(distribute(robot, at, options=options), wanted)


@pytest.mark.parametrize("name", ["closed_form", "pseudo_inverse"])
def test_other_solvers_with_lanes(robot, always, name):
    at = poses(robot, 100)
    expect_same(distribute(robot, at, solver=name), distribute(robot, at, solver=alone(robot, name)))


def test_cables_over_pulleys(always):
    robot = loaded("cogiro_pulleys")
    at = poses(robot, 40, 0.1)
    expect_same(distribute(robot, at), distribute(robot, at, solver=alone(robot)))


class Lying(MinimumNorm):
    """For eight at once it reports success, and has written the lowest tensions."""

    def side_by_side(self, W, wrench, t_min, t_max, tension):
        def solve(place, time):
            tension[...] = t_min
            return 0

        return by_python(solve)


def test_an_operation_for_eight_is_not_believed(robot, always):
    at = poses(robot, 40)
    solver = Lying(robot, QpOptions())
    expect_same(distribute(robot, at, solver=solver), distribute(robot, at, solver=alone(robot)))
