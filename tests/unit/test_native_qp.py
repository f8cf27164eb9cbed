"""Least norm, nearest wrench and policies in the kernel library: the bits of numba, and of one lane in eight."""

from __future__ import annotations

import doctest
import math
from importlib import import_module

import numpy as np
import pytest
from kernel_cases import COUNT, HOSTILE, assert_same_bits, rubbish, run, run_lanes
from solver_kernel_cases import EACH, NAMES, SHAPES, compiled, problems

from cdpr.model.address import address
from cdpr.tension import active_set, null_space, row_space
from cdpr.tension.box_least_squares import box_least_squares
from cdpr.tension.box_least_squares import work_rows as box_rows
from cdpr.tension.status import Status
from cdpr_solvers import best_effort, qp

SIZES = {"status": (1,)}
MANY = [(n, m) for n in range(1, 7) for m in range(n, 25)]

# about, change, whether weighted
QUESTIONS = [
    (qp.ZERO, math.inf, 0),
    (qp.MIDDLE, math.inf, 0),
    (qp.PREVIOUS, math.inf, 0),
    (qp.GIVEN, math.inf, 0),
    (qp.ZERO, math.inf, 1),
    (qp.ZERO, 20.0, 0),
    (qp.GIVEN, 50.0, 1),
    (qp.MIDDLE, math.inf, 1),
    (qp.PREVIOUS, 5.0, 1),
]


def asked(rng, n, m):
    """Problems with references, some far away, weights, and tensions of the step before, some unknown."""
    inputs = problems(rng, n, m)
    inputs["reference"] = rng.uniform(0.0, 400.0, (EACH, m)) * 10.0 ** rng.choice([0, 0, 0, 8, 15], (EACH, 1))
    inputs["root"] = np.sqrt(10.0 ** rng.uniform(-2.0, 2.0, (EACH, m)))
    before = np.clip(inputs["tension_min"] + rng.uniform(0.0, 100.0, (EACH, m)), 0.0, 400.0)
    before[::4, 0] = np.nan
    before[1::16, -1] = rng.choice(HOSTILE, len(before[1::16]))
    return inputs, {"tension": before}


@pytest.mark.slow
@compiled
def test_least_norm_has_the_bits_of_numba_and_of_each_lane():
    rng, statuses, count = np.random.default_rng(1), np.zeros(5, dtype=int), 0
    rows = address(row_space.nearest_by_rows, row_space.BY_ROWS)
    for shape, (n, m) in enumerate(SHAPES):
        inputs, before = asked(rng, n, m)
        work = np.empty((qp._rows(n, m), max(n, m)))
        by_rows = rows if row_space.worthwhile(n, m) else 0.0
        for about, change, weighted in dict.fromkeys([QUESTIONS[0], QUESTIONS[shape % len(QUESTIONS)]]):
            wanted, codes = before["tension"].copy(), np.empty(EACH, dtype=int)
            for k in range(EACH):
                rubbish(work)
                numbers = [about, change, weighted, by_rows, *inputs["reference"][k], *inputs["root"][k]]
                codes[k] = qp.minimum_norm(*(inputs[key][k] for key in NAMES), wanted[k], np.array(numbers), work)
            sizes = {"tension": (m,), **SIZES}
            values = {"about": about, "change": change, "weighted": weighted}
            found, given = run("minimum_norm", inputs, sizes, before, **values)
            assert given.tolist() == codes.tolist() == found["status"][:, 0].tolist()
            assert_same_bits(found["tension"], wanted)
            answered = codes == Status.OK
            lanes, groups = run_lanes("minimum_norm", inputs, sizes, before, **values)
            assert lanes["status"][:, 0].tolist() == codes.tolist()
            assert_same_bits(lanes["tension"][answered], wanted[answered])
            assert [group >> lane & 1 for group in groups for lane in range(8)] == (~answered).astype(int).tolist()
            statuses += np.bincount(codes, minlength=5)
            count += EACH
    assert count >= COUNT
    assert (statuses > 20).all()


def polytopes(rng, m, r):
    """Bases with equal and zero rows and wide numbers, limits that hold x back, exclude each other, or are hostile."""
    N = np.linalg.qr(rng.normal(size=(EACH, m, r)))[0]
    middle = np.einsum("kmr,kr->km", N, rng.normal(scale=30.0, size=(EACH, r)))
    center = rng.normal(scale=5.0, size=(EACH, m))
    width = rng.uniform(0.0, 20.0, (EACH, 2, m))
    low, high = center + middle - width[:, 0], center + middle + width[:, 1]
    for k in range(EACH // 2, EACH):
        i = rng.integers(m)
        match k % 6:
            case 0:
                N[k, i] = 0.0
            case 1:
                N[k, i] = N[k, rng.integers(m)]
            case 2:
                low[k, : m // 2], high[k, m // 2 :] = -np.inf, np.inf
            case 3:
                low[k, i], high[k, i] = high[k, i], low[k, i]
            case 4:
                (low[k], high[k], center[k])[rng.integers(3)][i] = rng.choice(HOSTILE)
            case 5:
                N[k, i, rng.integers(r)] = rng.choice(HOSTILE)
    return {
        "basis": N,
        "box": np.stack([center, low, high], axis=1),
        "objective": rng.choice([0.0, 1.0, -1.0], (EACH, r)) * rng.uniform(0.5, 2.0, (EACH, r)),
    }


@pytest.mark.slow
@compiled
def test_points_of_polytopes_have_the_bits_of_numba():
    rng, count, statuses = np.random.default_rng(2), 0, np.zeros(5, dtype=int)
    for m in range(1, 17):
        for r in range(1, min(m, 8) + 1):
            inputs = polytopes(rng, m, r)
            work = np.empty((active_set.work_rows(r), m))
            shapes = {"x": (r,), "point": (m,), "active": (m,), "steps": (1,)}
            for name in ("nearest_point", "extreme_point"):
                wanted = {key: np.empty((EACH, *shape)) for key, shape in shapes.items()}
                for k in range(EACH):
                    rubbish(work)
                    given = [inputs["basis"][k], r, inputs["box"][k], wanted["x"][k], wanted["point"][k]]
                    given += [wanted["active"][k], work]
                    if name == "nearest_point":
                        wanted["steps"][k] = active_set.nearest(*given)
                    else:
                        wanted["steps"][k] = active_set.extreme(inputs["objective"][k], *given)
                used = {key: value for key, value in inputs.items() if key != "objective" or name == "extreme_point"}
                found, codes = run(name, used, shapes)
                for key in shapes:
                    assert_same_bits(found[key], wanted[key])
                assert codes.tolist() == np.maximum(-wanted["steps"][:, 0], 0.0).tolist()
                count += EACH
                statuses += np.bincount(codes, minlength=5)
    assert count >= 2 * COUNT
    assert (statuses[[Status.OK, Status.INFEASIBLE, Status.UNSUPPORTED]] > 50).all()


@pytest.mark.slow
@compiled
def test_newton_in_the_row_space_has_the_bits_of_numba():
    rng, count, statuses = np.random.default_rng(3), 0, np.zeros(5, dtype=int)
    for n, m in MANY:
        inputs, _ = asked(rng, n, m)
        given = {key: inputs[key] for key in NAMES} | {"target": inputs["reference"]}
        wanted, codes = np.empty((EACH, m)), np.empty(EACH, dtype=int)
        B, box, work = np.empty((m, m)), np.empty((3, m)), np.empty((null_space.work_rows(n), max(n, m)))
        for k in range(EACH):
            for array in (B, box, work):
                rubbish(array)
            arrays = [value[k] for value in given.values()]
            codes[k] = row_space.nearest_by_rows(*arrays, wanted[k], B, box, work)
        found, statuses_found = run("nearest_by_rows", given, {"tension": (m,), **SIZES})
        assert statuses_found.tolist() == codes.tolist() == found["status"][:, 0].tolist()
        answered = codes == Status.OK
        assert_same_bits(found["tension"][answered], wanted[answered])
        statuses += np.bincount(codes, minlength=5)
        count += EACH
    assert count >= COUNT
    assert (statuses[[Status.OK, Status.INFEASIBLE, Status.NOT_FOUND, Status.BAD_INPUT]] > 50).all()


def excessive(rng, n, m):
    """Problems of which many ask for more than the cables can do."""
    inputs = problems(rng, n, m)
    with np.errstate(over="ignore"):
        inputs["wrench"][::2] *= rng.uniform(1.0, 20.0, inputs["wrench"][::2].shape)
    inputs["weights"] = rng.uniform(0.3, 3.0, (EACH, n))
    return inputs


@pytest.mark.slow
@compiled
@pytest.mark.parametrize("name", ["box_least_squares", "best_effort"])
def test_nearest_wrenches_have_the_bits_of_numba(name):
    rng, count, statuses = np.random.default_rng(4), 0, np.zeros(5, dtype=int)
    for n, m in SHAPES:
        inputs, before = excessive(rng, n, m), rng.uniform(0.0, 100.0, (EACH, m))
        wanted, codes, steps = before.copy(), np.empty(EACH, dtype=int), np.empty(EACH, dtype=int)
        work = np.empty((box_rows(n, m), max(n, m)))
        for k in range(EACH):
            rubbish(work)
            W, wrench, low, high, weights = (value[k] for value in inputs.values())
            if name == "best_effort":
                codes[k] = best_effort.best_effort(W, wrench, low, high, wanted[k], weights, work)
            else:
                steps[k] = box_least_squares(W, wrench, weights, low, high, wanted[k], work)
                codes[k] = max(-steps[k], 0)
        found, given = run(name, inputs, {"tension": (m,), **SIZES, "steps": (1,)}, {"tension": before})
        assert given.tolist() == codes.tolist() == found["status"][:, 0].tolist()
        assert_same_bits(found["tension"], wanted)
        if name == "box_least_squares":
            assert found["steps"][:, 0].tolist() == np.maximum(steps, 0).tolist()
        statuses += np.bincount(codes, minlength=5)
        count += EACH
    assert count >= COUNT
    assert statuses[Status.OK] > 1000
    assert statuses[Status.UNSUPPORTED] > 20


MODULES = ["cdpr.tension.active_set", "cdpr.tension.row_space", "cdpr.tension.box_least_squares", "cdpr.tension.policy"]


@pytest.mark.parametrize("module", [*MODULES, "cdpr_solvers.qp", "cdpr_solvers.best_effort"])
def test_functions_answer_what_their_docs_say(module):
    found = doctest.testmod(import_module(module))
    assert found.attempted
    assert not found.failed


def test_least_norm_near_something_else():
    W = np.array([[1.0, -1.0, 0.5], [0.2, 0.3, -1.0]])
    t, low, high = np.array([30.0, 20.0, 25.0]), np.full(3, 1.0), np.full(3, 100.0)
    tension, status = qp.minimum_norm_tension(W, W @ t, low, high, about="given", reference=t)
    assert status == Status.OK
    np.testing.assert_allclose(tension, t)
    for options in ({"change": 0.5}, {"about": "previous"}):
        tension, status = qp.minimum_norm_tension(W, W @ t, low, high, previous=t, **options)
        assert np.abs(tension - t).max() <= 0.5 + 1e-9
    with pytest.raises(ValueError, match="about: unknown value 'nothing'; allowed: zero, middle, previous, given"):
        qp.minimum_norm_tension(W, W @ t, low, high, about="nothing")
    assert qp.minimum_norm_tension(W, W @ t, low, [100.0, np.inf, 100.0], about="middle")[1] == Status.UNSUPPORTED
