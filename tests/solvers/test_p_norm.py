"""The p-norm about the middle of the limits against its conditions, scipy and itself."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import crossed_box, make_robot, random_state
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.linalg import null_space
from scipy.optimize import minimize
from test_classic import HIGH, LOW, NEAR, solve
from test_qp import loads, problem, seeds

from cdpr.mechanics import kinematics
from cdpr.tension import Status
from cdpr_solvers.options import PNormOptions
from cdpr_solvers.p_norm import PNorm


@pytest.mark.slow
@pytest.mark.parametrize("m", [7, 8, 9, 12])
@pytest.mark.usual("8")
def test_p_norm_converges_on_ten_thousand_problems(m):
    """2500 for each m: N^T u^(p-1) = 0 for any limits, feasible or not."""
    rng = np.random.default_rng(m)
    problems = []
    for k in range(2500):
        if k % 50 == 0:
            robot = make_robot(crossed_box(rng, m), limits=(LOW, HIGH))
        W = kinematics.wrench_matrix(robot, random_state(rng))
        wrench = W @ rng.uniform(LOW, HIGH, m)
        if k % 2:
            wrench = np.array([0, 0, 200.0, 0, 0, 0]) + rng.choice([0, 300.0, 3000.0]) * rng.normal(size=6)
        problems.append((W, wrench))
    N = np.linalg.svd(np.array([W for W, _ in problems]))[2][:, 6:]
    for p in (2, 4, 8, 16, 32):
        solver = PNorm(robot, PNormOptions(p=p))
        t = np.full((len(problems), m), np.nan)
        for (W, wrench), row in zip(problems, t, strict=True):
            assert solver.solve(W, wrench, robot.tension_min, robot.tension_max, row) in (Status.OK, Status.NOT_FOUND)
        assert np.isfinite(t).all()
        u = (t - 255.0) / 245.0
        u /= np.abs(u).max(1, keepdims=True)
        slope = np.abs(np.einsum("krm,km->kr", N, u ** (p - 1))).max(1)
        size = np.einsum("krm,km->kr", np.abs(N), np.abs(u) ** (p - 1)).max(1)
        assert (slope / size).max() < 1e-10


@pytest.mark.slow
@given(seeds, st.integers(7, 12), loads, st.sampled_from([2, 4, 6, 10]))
def test_p_norm_is_the_least_that_scipy_finds(seed, m, load, p):
    robot, W, wrench = problem(seed, m, load)
    rng = np.random.default_rng(seed)
    low = rng.uniform(0.0, 100.0, m)
    high = low + rng.uniform(100.0, 500.0, m)
    status, t = solve((PNorm, PNormOptions(p=p)), robot, W, wrench, low, high)
    N, start = null_space(W), np.linalg.pinv(W) @ wrench

    def total(t):
        return (((t - 0.5 * (low + high)) / (0.5 * (high - low))) ** p).sum() ** (1.0 / p)

    found = minimize(lambda x: total(start + N @ x), N.T @ (0.5 * (low + high)), options={"gtol": 1e-9})
    np.testing.assert_allclose(W @ t, wrench, atol=1e-9 * max(1.0, np.abs(wrench).max()))
    assert total(t) <= found.fun * (1.0 + 1e-12) + 1e-12
    inside = np.minimum(t - low, high - t).min()
    if abs(inside) > NEAR:
        assert status == (Status.OK if inside > 0.0 else Status.NOT_FOUND)


@given(seeds, st.integers(7, 12), loads, st.sampled_from([16, 32, 64]))
def test_p_norm_with_a_high_exponent_does_not_depend_on_the_order_of_the_cables(seed, m, load, p):
    """To a millionth of what is physical: the weights of the least squares span more decades than a float has."""
    robot, W, wrench = problem(seed, m, load)
    _, t = solve((PNorm, PNormOptions(p=p)), robot, W, wrench)
    order = np.random.default_rng(seed).permutation(m)
    _, permuted = solve((PNorm, PNormOptions(p=p)), robot, np.ascontiguousarray(W[:, order]), wrench)
    np.testing.assert_allclose(permuted, t[order], atol=1e-7 * max(HIGH, np.abs(t).max()))


@pytest.mark.parametrize("p", [0, 3, 66, 4.0])
def test_p_is_an_even_number(p):
    with pytest.raises(ValidationError):
        PNormOptions(p=p)
