"""The exact solver against problems solved by hand and the optimality conditions, in rational numbers."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from test_libraries import assert_true, odd_problems
from test_qp import problem, solve

from cdpr.tension import Status
from cdpr_solvers.exact import Exact, fractions, independent, least_norm, least_sum, nearest, solution, whole
from cdpr_solvers.options import ExactOptions

ROUNDED = 1e-9  # of the largest limit: the accuracy of `qp`


def ask(W, wrench, low, high, objective="min_norm"):
    W = np.array(W, dtype=float)
    t = np.full(W.shape[1], np.nan)
    solver = Exact(problem(0, W.shape[1], 0.0)[0], ExactOptions(objective=objective))
    status = solver.solve(W, np.array(wrench, dtype=float), np.array(low, dtype=float), np.array(high, dtype=float), t)
    return status, t.tolist()


def pieces(W, wrench, low, high):
    """Return the arguments of `least_norm`."""
    rows = independent([whole([*row, w]) for row, w in zip(W, wrench, strict=True)])
    return [row[:-1] for row in rows], [row[-1] for row in rows], fractions(low), fractions(high)


@pytest.mark.parametrize(
    ("W", "wrench", "low", "high", "expected"),
    [
        ([[1, 1]], [4], [0, 0], [9, 9], [2, 2]),  # shared equally
        ([[1, 1]], [4], [0, 0], [1, 9], [1, 3]),  # the first at its upper limit
        ([[1, 1]], [4], [3, 0], [9, 9], [3, 1]),  # at its lower one
        ([[1, -1]], [3], [1, 1], [9, 9], [4, 1]),  # a carriage between two cables
        ([[1, -1]], [8], [1, 1], [9, 9], [9, 1]),  # one point is left
        ([[1, 2]], [10], [0, 0], [9, 9], [2, 4]),  # in proportion to W
        ([[1, 0, 1], [0, 1, 1]], [3, 3], [0, 0, 0], [9, 9, 9], [1, 1, 2]),
        ([[1, 0, 1], [0, 1, 1]], [3, 3], [0, 0, 0], [9, 9, 1], [2, 2, 1]),
        ([[1, 1, 1]], [1], [0, 0, 0], [1, 1, 1], [1 / 3, 1 / 3, 1 / 3]),  # rounded once
        ([[1, 1], [2, 2]], [4, 8], [0, 0], [9, 9], [2, 2]),  # dependent rows
        ([[0, 0]], [0], [1, -2], [9, 9], [1, 0]),  # no equation: the limits alone
        ([[1, 1]], [4], [1, 3], [1, 3], [1, 3]),  # all locked
    ],
)
def test_solved_by_hand(W, wrench, low, high, expected):
    assert ask(W, wrench, low, high) == (Status.OK, expected)


def test_least_sum_by_hand():
    """The cable with the better lever carries all that it may."""
    assert ask([[1, 2]], [10], [0, 0], [9, 9], "one_norm") == (Status.OK, [0, 5])
    assert ask([[1, 2]], [10], [0, 0], [9, 3], "one_norm") == (Status.OK, [4, 3])
    assert ask([[1, 2]], [10], [1, 0], [9, 9], "one_norm") == (Status.OK, [1, 4.5])
    assert sum(ask([[1, 1]], [4], [0, 0], [9, 9], "one_norm")[1]) == 4  # any share of it
    assert ask([[1, 1]], [19], [0, 0], [9, 9], "one_norm")[0] == Status.INFEASIBLE


def test_feasibility_is_decided_to_the_last_bit():
    above = np.nextafter(18.0, 19.0)
    assert ask([[1, 1]], [18], [0, 0], [9, 9]) == (Status.OK, [9, 9])
    assert ask([[1, 1]], [above], [0, 0], [9, 9])[0] == Status.INFEASIBLE
    assert ask([[1, 1], [1, 1]], [4, 4.1], [0, 0], [9, 9])[0] == Status.INFEASIBLE
    assert ask([[1], [1]], [4, 4], [0], [9]) == (Status.OK, [4])
    assert ask([[1], [1]], [4, 5], [0], [9])[0] == Status.INFEASIBLE
    assert ask([[0, 0]], [5e-324], [0, 0], [9, 9])[0] == Status.INFEASIBLE
    tiny, huge = 2.0**-500, 2.0**500  # far beyond what floating point could subtract
    assert ask([[huge, tiny]], [huge], [0, 0], [1, huge * huge]) == (Status.OK, [1, tiny / huge])


def solved(A, b):
    """Some x with A x = b, or None, by plain elimination over the fractions."""
    rows = [[Fraction(x) for x in (*row, right)] for row, right in zip(A, b, strict=True)]
    pivots = []
    for column in range(len(A[0]) if A else 0):
        k = len(pivots)
        found = next((row for row in rows[k:] if row[column]), None)
        if found is None:
            continue
        rows.remove(found)
        rows.insert(k, [x / found[column] for x in found])
        for i, row in enumerate(rows):
            if i != k and row[column]:
                rows[i] = [x - row[column] * y for x, y in zip(row, rows[k], strict=True)]
        pivots.append(column)
    if any(row[-1] for row in rows[len(pivots) :]):
        return None
    x = [Fraction(0)] * (len(A[0]) if A else 0)
    for row, column in zip(rows, pivots, strict=False):
        x[column] = row[-1]
    return x


def candidates(W, wrench, low, high):
    """All admissible t that are the shortest with some cables held at some limits: the optima are among them."""
    for held in product((None, low, high), repeat=len(low)):
        t = [None if at is None else Fraction(at[i]) for i, at in enumerate(held)]
        free = [i for i, x in enumerate(t) if x is None]
        rest = [
            w - sum(a * x for a, x in zip(row, t, strict=True) if x is not None)
            for row, w in zip(W, wrench, strict=True)
        ]
        y = solved([[sum(a[i] * b[i] for i in free) for a in W] for b in W], rest)
        if y is None:
            continue
        for i in free:
            t[i] = sum((c * row[i] for c, row in zip(y, W, strict=True)), Fraction(0))
        if all(a <= x <= b for a, x, b in zip(low, t, high, strict=True)):
            yield t


@st.composite
def small_problems(draw):
    """Small whole numbers: dependent rows, equal and empty columns, locked cables and contradictions abound."""
    n, m = draw(st.integers(1, 3)), draw(st.integers(1, 4))
    W = draw(st.lists(st.lists(st.integers(-2, 2), min_size=m, max_size=m), min_size=n, max_size=n))
    low = draw(st.lists(st.integers(-2, 2), min_size=m, max_size=m))
    width = draw(st.lists(st.integers(0, 4), min_size=m, max_size=m))
    inside = draw(st.lists(st.integers(0, 4), min_size=m, max_size=m))
    off = draw(st.sampled_from([0, 0, 0, 1]))
    wrench = [sum(a * (b + min(c, d)) for a, b, c, d in zip(row, low, width, inside, strict=True)) + off for row in W]
    return W, wrench, low, [a + b for a, b in zip(low, width, strict=True)]


@given(small_problems())
def test_it_finds_the_best_of_all_active_sets(small):
    W, wrench, _, _ = small
    all_of_them = list(candidates(*small))
    rows = independent([whole([*row, w]) for row, w in zip(W, wrench, strict=True)])
    if not all_of_them:
        assert rows is None or least_norm(*pieces(*small)) is None
        assert rows is None or least_sum(*pieces(*small)) is None
        return
    assert least_norm(*pieces(*small)) == min(all_of_them, key=lambda t: sum(x * x for x in t))
    assert sum(least_sum(*pieces(*small))) == min(map(sum, all_of_them))


@pytest.mark.parametrize("m", [6, 7, 8, 10, 12])
def test_karush_kuhn_tucker_without_tolerance(m):
    """t = W^T y + multipliers of the right sign, y determined by the cables inside their limits, exact to the bit."""
    certified = 0
    for seed in range(20):
        robot, W, _ = problem(seed, m, 0.0)
        wrench = W @ np.random.default_rng(seed).uniform(10.0, 500.0, m)
        rows, right, low, high = pieces(W, wrench, robot.tension_min, robot.tension_max)
        t = least_norm(rows, right, low, high)
        if t is None:
            assert m == 6 or seed < 0  # with no cable to spare the rounded wrench may be out of reach
            continue
        assert [sum(a * x for a, x in zip(row, t, strict=True)) for row in rows] == right
        assert all(a <= x <= b for a, x, b in zip(low, t, high, strict=True))
        free = [i for i in range(m) if low[i] < t[i] < high[i]]
        y = solved([[row[i] for row in rows] for i in free], [t[i] for i in free])
        assert y is not None
        if len(free) < len(rows):
            continue  # y is not unique
        for i in range(m):
            rest = t[i] - sum(c * row[i] for c, row in zip(y, rows, strict=True))
            assert rest == 0 or (t[i] == low[i] if rest > 0 else t[i] == high[i])
        certified += 1
    assert certified >= 10


@pytest.mark.slow
@pytest.mark.parametrize("load", [0.0, 60.0, 300.0])
def test_qp_agrees(load):
    """Over many random problems, also about whether there is an answer."""
    seen = set()
    for seed in range(100):
        m = 7 + seed % 6
        robot, W, wrench = problem(seed, m, load)
        status, t = ask(W, wrench, robot.tension_min, robot.tension_max)
        other, best = solve(robot, W, wrench)
        assert status == other
        if status == Status.OK:
            np.testing.assert_allclose(t, best, atol=ROUNDED * 500.0)
            assert np.all(t >= robot.tension_min)
            assert np.all(t <= robot.tension_max)
        seen.add(status)
    assert Status.OK in seen


@pytest.mark.parametrize("m", [4, 6, 9])
@pytest.mark.parametrize("objective", ["min_norm", "one_norm"])
def test_odd_problems_have_defined_outcomes(m, objective):
    """A rounded wrench that must satisfy dependent equations, or more than unknowns, may miss them."""
    for name, (W, wrench, low, high, possible) in odd_problems(m).items():
        status, t = ask(W, wrench, low, high, objective)
        if status == Status.OK:
            assert possible, name
            assert_true(W, wrench, low, high, np.array(t))
        else:
            assert status == Status.INFEASIBLE
            rows_to_spare = np.linalg.matrix_rank(W[:, low < high]) == len(W)
            assert not possible or not rows_to_spare or m == 6, name


def test_nearest_to_any_target():
    low, high = fractions([0.0, 0.0]), fractions([9.0, 9.0])
    assert nearest([[1, 1]], [4], low, high, fractions([3.0, 0.0])) == [Fraction(7, 2), Fraction(1, 2)]
    assert nearest([[1, 1]], [4], low, high, fractions([30.0, 0.0])) == [4, 0]


def test_solution_of_equations():
    numbers, unit = solution([[2, 1], [1, 3]], [Fraction(1, 2), 1])
    assert [Fraction(x, unit) for x in numbers] == [Fraction(1, 10), Fraction(3, 10)]


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_bad_input(bad):
    for case in (
        ([[1, bad]], [4], [0, 0], [9, 9]),
        ([[1, 1]], [bad], [0, 0], [9, 9]),
        ([[1, 1]], [4], [0, bad], [9, 9]),
        ([[1, 1]], [4], [0, 5], [9, 4]),
    ):
        assert ask(*case)[0] == Status.BAD_INPUT
    unbounded = Status.UNSUPPORTED if bad == np.inf else Status.BAD_INPUT
    assert ask([[1, 1]], [4], [0, 0], [9, bad])[0] == unbounded


def test_options():
    with pytest.raises(ValidationError, match="min_norm"):
        ExactOptions(objective="two_norm")
