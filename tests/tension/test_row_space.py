"""The qp of robots with many cables: Newton's method on the equations, against the null space and the exact solver."""

from __future__ import annotations

import numpy as np
import pytest
from spread import sampled
from tension_operations import box_least_squares

from cdpr.analysis.bench import adversaries
from cdpr.model import DOF_NAMES
from cdpr.tension.active_set import nearest_point
from cdpr.tension.admissible import general_solution
from cdpr.tension.row_space import nearest_tension_by_rows
from cdpr.tension.status import BAD_INPUT, INFEASIBLE, NOT_FOUND, OK
from cdpr_solvers.exact import fractions, independent, least_norm, whole
from cdpr_solvers.qp import minimum_norm_tension

SAME = 1e-9  # of the largest tension: two exact methods on problems that are no slivers
BALANCED = 1e-12  # of the load: round-off
BAND = 1e-9  # relative distance from the edge of the feasible set within which round-off decides


def matrix(rng, n, m):
    """Columns as of a robot: unit vectors, and moments with arms up to half a metre."""
    u = rng.normal(size=(3, m))
    u /= np.linalg.norm(u, axis=0)
    arms = rng.uniform(-0.5, 0.5, (m, 3))
    return np.ascontiguousarray(np.vstack([u, np.cross(arms, u.T).T])[:n])


def by_rows(W, wrench, low, high, target=None):
    t, status = nearest_tension_by_rows(W, wrench, low, high, np.zeros(len(low)) if target is None else target)
    return status, t


def by_null_space(W, wrench, low, high):
    form = general_solution(W, wrench, low, high)
    if form is None:
        return (INFEASIBLE if np.isfinite(W).all() else BAD_INPUT), np.full(len(low), np.nan)
    _, t, status = nearest_point(form[1], form[0], low, high)
    return status, t


def qp(W, wrench, low, high):
    t, status = minimum_norm_tension(W, wrench, low, high)
    return status, t


def exactly(W, wrench, low, high):
    """The optimum in rational numbers, None where there is none."""
    rows = independent([whole([*row, w]) for row, w in zip(W, wrench, strict=True)])
    if rows is None:
        return None
    answer = least_norm([row[:-1] for row in rows], [row[-1] for row in rows], fractions(low), fractions(high))
    return None if answer is None else np.array([float(x) for x in answer])


@pytest.mark.parametrize(("n", "m"), [(2, 9), (3, 8), (3, 30), (6, 13), (6, 32), (6, 100)])
def test_both_methods_agree(n, m):
    """Same verdict and same tensions, from loads that nothing limits to loads beyond all limits."""
    rng = np.random.default_rng(m)
    seen, undecided = set(), 0
    for load in np.repeat([0.1, 1.0, 3.0, 10.0], 12):
        W, low = matrix(rng, n, m), rng.uniform(1.0, 50.0, m)
        high = low + rng.uniform(10.0, 400.0, m)
        wrench = W @ rng.uniform(low, high) + load * 100.0 * np.abs(rng.normal()) * W[:, 0]
        (status, t), (expected, wanted) = by_rows(W, wrench, low, high), by_null_space(W, wrench, low, high)
        undecided += status == NOT_FOUND
        if status != NOT_FOUND:
            assert status == expected
            seen.add(status)
        if status == OK:
            assert np.abs(t - wanted).max() <= SAME * high.max()
            assert np.abs(W @ t - wrench).max() <= BALANCED * max(np.abs(wrench).max(), high.max()) * np.sqrt(m)
            assert np.all((low <= t) & (t <= high))
    assert OK in seen
    assert undecided <= 1  # of 48, or the shortcut would be none


def odd_problems(rng, n, m, count):
    """Parallel columns, cables at a limit, locked ones, rank-deficient W, scales, sets without an interior."""
    for k in range(count):
        W, low = matrix(rng, n, m), rng.uniform(1.0, 50.0, m)
        high = low + rng.uniform(10.0, 400.0, m)
        kind = k % 6
        if kind == 0:
            W[:, 1::2] = W[:, ::2][:, : m // 2] * rng.choice([1.0, -1.0, 0.5], m // 2)
        elif kind == 1:
            locked = rng.random(m) < 0.3
            high[locked] = low[locked]
        elif kind == 2:
            W[n - 1] = 2.0 * W[0]  # exactly
        elif kind == 3:
            W[n // 2 :] *= 100.0
        t = rng.uniform(low, high)
        at = rng.random(m) < (0.95 if kind == 4 else 0.4)
        t[at] = np.where(rng.random(m) < 0.5, low, high)[at]
        if kind == 5:  # as far as the cables can: one point, give or take round-off
            y = rng.normal(size=n)
            t = np.where(y @ W > 0.0, high, low)
        scale = rng.choice([1e-3, 1.0, 1e6]) if kind == 3 else 1.0
        yield W, W @ t * scale, low * scale, high * scale


@sampled(1, ("n", "m"), [(2, 7), (3, 9), (6, 14)])
def test_odd_problems_against_rational_numbers(n, m):
    """Each has a solution but for the rounding of its wrench: none is called infeasible, and answers are optimal."""
    rng = np.random.default_rng(n)
    compared = 0
    for W, wrench, low, high in odd_problems(rng, n, m, 60):
        largest = high.max()
        status, t = by_rows(W, wrench, low, high)
        assert status in (OK, NOT_FOUND)
        assert qp(W, wrench, low, high)[0] == OK
        wanted = exactly(W, wrench, low, high)
        if status == OK:
            assert np.abs(W @ t - wrench).max() <= BALANCED * np.abs(W).max() * largest * m
            # If rounding left a solution, and not only a sliver: the optimum.
            shrunk = np.where(low < high, BAND * largest, 0.0)
            if wanted is not None and exactly(W, wrench, low + shrunk, high - shrunk) is not None:
                compared += 1
                assert np.abs(t - wanted).max() <= 1e-6 * largest
    assert compared >= 5


@pytest.mark.parametrize(("dof", "m"), [(("x", "z"), 7), (("x", "y", "z"), 12), (DOF_NAMES, 20)])
def test_problems_made_to_mislead(monkeypatch, dof, m):
    """The benchmark's, at sizes where the rows are fewer: nothing misclassified, and the rows alone are never wrong."""
    monkeypatch.setattr(adversaries, "SIZES", ((dof, m),))
    problems = adversaries.adversaries(adversaries.robots()[0], 300, 11)
    for k in range(len(problems)):
        expected = OK if problems.feasible[k] else INFEASIBLE
        given = problems.W[k].copy(), problems.wrench[k].copy(), problems.low[k].copy(), problems.high[k].copy()
        assert by_rows(*given)[0] in (expected, NOT_FOUND)
        status, t = qp(*given)
        if not problems.slack[k] < adversaries.BAND:
            assert status == expected
        if status == OK:
            assert np.all((given[2] <= t) & (t <= given[3]))
            sizes = np.abs(given[0]) @ np.abs(t) + np.abs(given[1])
            assert np.all(np.abs(given[0] @ t - given[1]) <= BALANCED * sizes)


def test_just_beyond_what_the_cables_can_is_infeasible():
    """A share of 1e-6 beyond the farthest wrench in a direction, and within it."""
    rng = np.random.default_rng(4)
    for _ in range(100):
        W, low = matrix(rng, 6, 20), rng.uniform(1.0, 50.0, 20)
        high = low + rng.uniform(10.0, 400.0, 20)
        far = W @ np.where(rng.normal(size=6) @ W > 0.0, high, low)
        inside = W @ (0.5 * (low + high))
        for share, expected in ((1e-6, INFEASIBLE), (-1e-6, OK)):
            wrench = far + share * (far - inside)
            assert by_rows(W, wrench, low, high)[0] in (expected, NOT_FOUND)
            assert qp(W, wrench, low, high)[0] == expected


def test_limits_without_end():
    rng = np.random.default_rng(5)
    W, low, high = matrix(rng, 6, 20), np.full(20, 10.0), np.full(20, np.inf)
    wrench = W @ rng.uniform(10.0, 100.0, 20)
    status, t = by_rows(W, wrench, low, high)
    assert status == OK == by_null_space(W, wrench, low, high)[0]
    assert np.abs(t - by_null_space(W, wrench, low, high)[1]).max() <= SAME * t.max()
    assert by_rows(W * np.nan, wrench, low, high)[0] == by_null_space(W * np.nan, wrench, low, high)[0]


def test_a_target_is_approached():
    """About the middle: as the least norm of what is shifted by it."""
    rng = np.random.default_rng(6)
    W, low, high = matrix(rng, 6, 20), rng.uniform(1.0, 50.0, 20), rng.uniform(60.0, 400.0, 20)
    middle, wrench = 0.5 * (low + high), W @ rng.uniform(low, high)
    t = by_rows(W, wrench, low, high, middle)[1]
    shifted = by_null_space(W, wrench - W @ middle, low - middle, high - middle)[1]
    assert np.abs(t - middle - shifted).max() <= SAME * high.max()


def test_the_nearest_wrench_of_many_cables_has_the_least_tensions():
    """If it balances: those of the qp."""
    rng = np.random.default_rng(7)
    for _ in range(5):
        W, low, high = matrix(rng, 6, 40), np.full(40, 5.0), np.full(40, 300.0)
        wrench, t = W @ rng.uniform(low, high), np.zeros(40)
        box_least_squares(W, wrench, np.ones(6), low, high, t)
        assert np.abs(t - qp(W, wrench, low, high)[1]).max() <= SAME * 300.0
