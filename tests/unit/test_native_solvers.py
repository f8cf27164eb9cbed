"""Tension solvers in the kernel library have the bits of the numba kernels."""

from __future__ import annotations

import doctest
from importlib import import_module

import numpy as np
import pytest
from kernel_cases import COUNT, assert_same_bits, run
from solver_kernel_cases import EACH, SHAPES, answers, compiled, problems

from cdpr.tension import active_set, null_space, safest
from cdpr.tension.null_space import form_rows
from cdpr.tension.status import Status
from cdpr_solvers import analytic_centre

# Shapes with few redundant cables, for methods that take no more.
FEW = [(n, n + r) for n in range(1, 7) for r in (0, 1, 1, 1, 2, 2, 2, 3)] * 2


def weighted(rng, m):
    """Weights of cables: all the same, or over some decades."""
    weights = 10.0 ** rng.uniform(-3.0, 3.0, (EACH, m))
    weights[::3] = 1.0
    return {"weights": weights}


def plain(n, m):
    """Rows and columns of most work spaces of numba, and some more."""
    return form_rows(m) + 3 + max(null_space.work_rows(n), active_set.work_rows(m)), max(n, m)


def polygons(n, m):
    return form_rows(m) + 1 + max(null_space.work_rows(n), 4 * m + 8), max(n, m, 2)


def powers(n, m):
    return form_rows(m) + m + 3 + max(null_space.work_rows(n), 2 * m + 5), max(n, m)


def largest(n, m):
    return form_rows(m) + 3 * m + 7 + max(null_space.work_rows(n), active_set.work_rows(m + 1)), max(n, 3 * m)


def farthest(n, m):
    return form_rows(m) + 1 + max(null_space.work_rows(n), safest.work_rows(m)), max(n, 2 * m + 1)


def central(n, m):
    return analytic_centre._rows(n, m), max(n, 2 * m + 1)


# Module and kernel, work space of numba, shapes, and pairs of numbers: of numba, and of the library by name.
NONE = [((), {})]
SOLVERS = {
    "dykstra": ("dykstra", plain, SHAPES, [((40, 1e-9), {"iterations": 40, "tolerance": 1e-9})]),
    "improved_closed_form": ("improved_closed_form", plain, SHAPES, [((0,), {"scaled": 0}), ((1,), {"scaled": 1})]),
    "puncture": ("puncture", plain, SHAPES, NONE),
    "improved_puncture": ("improved_puncture", plain, SHAPES, [((0,), {})]),
    "kernel_method": ("kernel_method", plain, FEW, NONE),
    "p_norm": ("p_norm", powers, SHAPES, [((p,), {"p": p}) for p in (4, 2, 6, 8, 64)]),
    "centroid": ("centroid", polygons, FEW, NONE),
    "minimum_sum": ("lp", plain, SHAPES, [(None, {})]),
    "minimum_largest": ("infinity_norm", largest, SHAPES, NONE),
    "maximin": ("maximin", farthest, SHAPES, [((0,), {"ball": 0}), ((1,), {"ball": 1})]),
    "analytic_centre": ("analytic_centre", central, SHAPES, [(None, {})]),
}


@pytest.mark.slow
@compiled
@pytest.mark.parametrize("name", SOLVERS)
def test_solvers_have_the_bits_of_numba(name):
    rng, (module, space, shapes, numbers) = np.random.default_rng(1), SOLVERS[name]
    solve = getattr(import_module(f"cdpr_solvers.{module}"), name)
    statuses, count = np.zeros(5, dtype=int), 0
    for k, (n, m) in enumerate(shapes):
        inputs, (theirs, ours) = problems(rng, n, m), numbers[k % len(numbers)]
        if theirs is None:
            inputs |= weighted(rng, m)
        expected, wanted = answers(solve, inputs, *space(n, m), theirs or ())
        found, codes = run(name, inputs, {"tension": (m,), "status": (1,)}, **ours)
        assert codes.tolist() == wanted.tolist() == found["status"][:, 0].tolist()
        answered = wanted == Status.OK
        assert_same_bits(found["tension"][answered], expected[answered])
        statuses += np.bincount(wanted, minlength=5)
        count += EACH
    assert count >= COUNT
    assert (statuses[[Status.OK, Status.INFEASIBLE, Status.BAD_INPUT]] > 100).all()


MODULES = [f"cdpr_solvers.{module}" for module, *_ in SOLVERS.values()]


@pytest.mark.parametrize("module", [*MODULES, "cdpr.tension.admissible"])
def test_functions_answer_what_they_say(module):
    done = doctest.testmod(import_module(module))
    assert done.attempted > 0
    assert done.failed == 0
