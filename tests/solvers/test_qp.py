"""The exact solvers against optimality conditions, a linear program and least squares of scipy."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import crossed_box, make_robot, random_state
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog, lsq_linear
from tension_operations import box_least_squares

from cdpr.mechanics import kinematics
from cdpr.tension import Status
from cdpr_solvers.options import QpOptions
from cdpr_solvers.pseudo_inverse import PseudoInverse
from cdpr_solvers.qp import MinimumNorm

pytestmark = pytest.mark.core

RESIDUAL = 1e-12  # relative to the largest tension or wrench: what is left of 1e-16 after a few hundred operations
OPTIMALITY = 1e-9  # of the largest tension
CERTAIN = 1e-7  # margins (of t_max) below which a linear program with its own tolerances is no oracle

seeds = st.integers(0, 2**32 - 1)
# Scale of the random wrench: from easily feasible to mostly infeasible.
loads = st.sampled_from([0.0, 50.0, 300.0, 1500.0])


def problem(seed: int, m: int, load: float):
    rng = np.random.default_rng(seed)
    robot = make_robot(crossed_box(rng, m), limits=(10.0, 500.0))
    W = kinematics.wrench_matrix(robot, random_state(rng))
    wrench = np.array([0, 0, 200.0, 0, 0, 0]) + load * rng.normal(size=6) * [1, 1, 1, 0.1, 0.1, 0.1]
    return robot, W, wrench


def solve(robot, W, wrench, low=None, high=None, solver=MinimumNorm):
    tension = np.full(robot.m, np.nan)
    low = robot.tension_min if low is None else low
    high = robot.tension_max if high is None else high
    status = solver(robot, QpOptions()).solve(W, wrench, low, high, tension)
    return status, tension


def margin(W, wrench, low, high) -> float:
    """Largest s with W t = wrench, low + s <= t <= high - s, by HiGHS; negative where infeasible, -inf if W cannot."""
    m = W.shape[1]
    A_ub = np.block([[-np.eye(m), np.ones((m, 1))], [np.eye(m), np.ones((m, 1))]])
    answer = linprog(
        [0.0] * m + [-1.0],
        A_ub=A_ub,
        b_ub=np.concatenate([-low, high]),
        A_eq=np.hstack([W, np.zeros((len(W), 1))]),
        b_eq=wrench,
        bounds=[(None, None)] * (m + 1),
    )
    return -answer.fun if answer.success else -np.inf


def assert_optimal(W, wrench, low, high, t):
    """Feasible exactly, and t = W^T y + multipliers of the right sign at limits (KKT, sufficient by convexity)."""
    scale = max(1.0, np.abs(t).max(), np.abs(wrench).max())
    assert np.abs(W @ t - wrench).max() <= RESIDUAL * scale
    assert np.all(t >= low)
    assert np.all(t <= high)
    # y must satisfy equalities at free cables and signs at the others: a small feasibility problem of its own.
    kinds = np.where(t == low, 1, 0) + np.where(t == high, 2, 0)
    A = W.T
    lower = np.where((kinds == 1) | (kinds == 3), -np.inf, t)
    upper = np.where((kinds == 2) | (kinds == 3), np.inf, t)
    slack = OPTIMALITY * scale
    rows = np.vstack([A, -A])
    limits = np.concatenate([np.where(kinds == 1, t, upper) + slack, -np.where(kinds == 2, t, lower) + slack])
    keep = np.isfinite(limits)
    answer = linprog(np.zeros(A.shape[1]), A_ub=rows[keep], b_ub=limits[keep], bounds=[(None, None)] * A.shape[1])
    assert answer.success, "no multipliers: not the optimum"


@given(seeds, st.integers(6, 12), loads)
def test_qp_is_optimal_or_rightly_infeasible(seed, m, load):
    robot, W, wrench = problem(seed, m, load)
    low, high = robot.tension_min, robot.tension_max
    status, t = solve(robot, W, wrench)
    truth = margin(W, wrench, low, high)
    if status == Status.OK:
        assert_optimal(W, wrench, low, high, t)
    else:
        assert status == Status.INFEASIBLE
    if abs(truth) > CERTAIN * 500.0:
        assert (status == Status.OK) == (truth > 0.0)


@given(seeds, st.integers(1, 5))
def test_fewer_cables_than_directions(seed, m):
    """Overdetermined: solvable only where the wrench happens to lie in the range of W, then by one t."""
    robot, W, wrench = problem(seed, m, 10.0)
    assert solve(robot, W, wrench)[0] == Status.INFEASIBLE
    inside = np.random.default_rng(seed).uniform(20.0, 400.0, m)
    status, t = solve(robot, W, W @ inside)
    assert status == Status.OK
    np.testing.assert_allclose(t, inside, rtol=1e-8)


@given(seeds)
def test_rank_deficient_duplicate_and_zero_columns(seed):
    robot, W, _ = problem(seed, 10, 0.0)
    W[:, 1] = W[:, 0]
    W[:, 2] = 0.0
    W[5] = W[4]  # a dependent row
    inside = np.random.default_rng(seed).uniform(50.0, 300.0, 10)
    status, t = solve(robot, W, W @ inside)
    assert status == Status.OK
    assert_optimal(W, W @ inside, robot.tension_min, robot.tension_max, t)
    wrong = W @ inside + np.array([0, 0, 0, 0, 1.0, 0])  # outside the range
    assert solve(robot, W, wrong)[0] == Status.INFEASIBLE


@given(seeds, st.sampled_from([0.0, 60.0]))
def test_locked_and_cut_cables_keep_their_tension(seed, locked):
    robot, W, _ = problem(seed, 9, 0.0)
    inside = np.random.default_rng(seed).uniform(50.0, 300.0, 9)
    low, high = robot.tension_min.copy(), robot.tension_max.copy()
    inside[4] = low[4] = high[4] = locked
    status, t = solve(robot, W, W @ inside, low, high)
    assert status == Status.OK
    assert t[4] == locked
    assert_optimal(W, W @ inside, low, high, t)


def test_every_cable_locked():
    robot, W, _ = problem(3, 8, 0.0)
    t0 = np.linspace(20.0, 90.0, 8)
    status, t = solve(robot, W, W @ t0, t0, t0)
    assert status == Status.OK
    np.testing.assert_array_equal(t, t0)
    assert solve(robot, W, W @ t0 + 1.0, t0, t0)[0] == Status.INFEASIBLE


@given(seeds, st.integers(7, 12))
def test_order_of_cables_and_scale_do_not_matter(seed, m):
    robot, W, wrench = problem(seed, m, 100.0)
    status, t = solve(robot, W, wrench)
    order = np.random.default_rng(seed).permutation(m)
    permuted_status, permuted = solve(robot, np.ascontiguousarray(W[:, order]), wrench)
    scaled_status, scaled = solve(robot, W, 1e3 * wrench, 1e3 * robot.tension_min, 1e3 * robot.tension_max)
    assert status == permuted_status == scaled_status
    if status == Status.OK:
        np.testing.assert_allclose(permuted, t[order], atol=OPTIMALITY * 500.0)
        np.testing.assert_allclose(scaled, 1e3 * t, atol=OPTIMALITY * 500e3)


def test_qp_is_continuous_along_a_path():
    """No jump: sampled 10 times finer, the largest step is about 10 times smaller, while limits come and go."""
    robot, W0, _ = problem(11, 8, 0.0)
    _, W1, _ = problem(12, 8, 0.0)
    inside0, inside1 = np.random.default_rng(5).uniform(10.0, 500.0, (2, 8))

    def largest_step(samples: int) -> tuple[float, int]:
        tensions, active = [], set()
        for s in np.linspace(0, 1, samples):
            W = W0 + s * (W1 - W0)
            status, t = solve(robot, W, W @ (inside0 + s * (inside1 - inside0)))
            assert status == Status.OK
            tensions.append(t)
            active.add(tuple((t == 10.0) | (t == 500.0)))
        return float(np.abs(np.diff(tensions, axis=0)).max()), len(active)

    coarse, kinds = largest_step(201)
    assert kinds > 1
    assert largest_step(2001)[0] < 0.2 * coarse


@given(seeds, st.integers(6, 12), loads)
def test_pseudo_inverse_is_numpys(seed, m, load):
    robot, W, wrench = problem(seed, m, load)
    status, t = solve(robot, W, wrench, solver=PseudoInverse)
    assert status == Status.OK
    np.testing.assert_allclose(t, np.linalg.pinv(W) @ wrench, rtol=1e-9, atol=1e-9 * np.abs(wrench).max())


@given(seeds, st.integers(1, 12), loads)
def test_box_least_squares_reaches_the_best_residual(seed, m, load):
    robot, W, wrench = problem(seed, m, load)
    low, high, t = robot.tension_min, robot.tension_max, np.empty(m)
    weights = np.array([1, 1, 1, 4.0, 4.0, 4.0])
    assert box_least_squares(W, wrench, weights, low, high, t) >= 0
    assert np.all(t >= low)
    assert np.all(t <= high)
    D = weights[:, None]
    best = lsq_linear(D * W, weights * wrench, bounds=(low, high), method="bvls", tol=1e-14)
    ours, theirs = np.linalg.norm(weights * (W @ t - wrench)), np.linalg.norm(best.fun)
    assert ours <= theirs + 1e-5 * max(1.0, np.linalg.norm(weights * wrench))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_non_finite_input_ends(bad):
    """The stage catches it; a solver must only come back."""
    robot, W, wrench = problem(1, 8, 0.0)
    wrench[2] = bad
    solve(robot, W, wrench)
    W[0, 0] = bad
    solve(robot, W, wrench)


def test_another_call_may_come_before_an_answer_is_taken():
    """Here the array that takes it makes the call; else another thread would. W is in Fortran's order, so copied."""
    robot, W, _ = problem(3, 8, 0.0)
    wrench, other = W @ np.full(8, 100.0), W @ np.linspace(100.0, 200.0, 8)
    solver, limits = MinimumNorm(robot, QpOptions()), (robot.tension_min, robot.tension_max)

    class Late(np.ndarray):
        def __setitem__(self, key, value):
            solver.solve(np.asfortranarray(W), other, *limits, np.full(8, np.nan))
            super().__setitem__(key, value)

    late = np.full(8, np.nan).view(Late)
    assert solver.solve(np.asfortranarray(W), wrench, *limits, late) == Status.OK
    np.testing.assert_array_equal(late, solve(robot, W, wrench)[1])
