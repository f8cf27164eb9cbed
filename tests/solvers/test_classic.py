"""The classical methods against numpy, scipy, the exact solver and each other."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from conftest import crossed_box, make_robot, random_state
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import null_space
from test_qp import loads, margin, problem, seeds

from cdpr.mechanics import kinematics
from cdpr.tension import Status
from cdpr_solvers.dykstra import Dykstra
from cdpr_solvers.improved_closed_form import ImprovedClosedForm
from cdpr_solvers.kernel_method import KernelMethod
from cdpr_solvers.options import DykstraOptions, ImprovedClosedFormOptions, PNormOptions, QpOptions
from cdpr_solvers.p_norm import PNorm
from cdpr_solvers.puncture import Puncture
from cdpr_solvers.qp import MinimumNorm

LOW, HIGH = 10.0, 500.0
NEAR = 1e-4  # N; closer to a limit, or to a tie of two cables, round-off may decide
CLOSE = {"rtol": 1e-9, "atol": 1e-7}

SOLVERS = {
    "published": (ImprovedClosedForm, ImprovedClosedFormOptions()),
    "scaled": (ImprovedClosedForm, ImprovedClosedFormOptions(rule="scaled")),
    "puncture": (Puncture, None),
    "kernel": (KernelMethod, None),
    "dykstra": (Dykstra, DykstraOptions()),
    "p_norm": (PNorm, PNormOptions()),
    "p_norm 64": (PNorm, PNormOptions(p=64)),
}
each_solver = pytest.mark.parametrize("name", SOLVERS)
names = st.sampled_from(sorted(SOLVERS))


def solve(name, robot, W, wrench, low=None, high=None):
    factory, options = SOLVERS[name] if isinstance(name, str) else name
    tension = np.full(robot.m, np.nan)
    low = robot.tension_min if low is None else low
    high = robot.tension_max if high is None else high
    return factory(robot, options).solve(W, wrench, low, high, tension), tension


def nearest(robot, W, wrench):
    return solve((MinimumNorm, QpOptions(about="middle")), robot, W, wrench)


@cache
def feasible(seed: int, m: int, count: int):
    """All of `found_feasible`, which refuses most of what it tries where m is 7."""
    return tuple(found_feasible(seed, m, count))


def found_feasible(seed: int, m: int, count: int):
    """Robots and problems with an answer: half from tensions within the limits, half under gravity and some load."""
    rng = np.random.default_rng(seed)
    robot = make_robot(crossed_box(rng, m), limits=(LOW, HIGH))
    while count > 0:
        W = kinematics.wrench_matrix(robot, random_state(rng))
        wrench = W @ rng.uniform(LOW, HIGH, m)
        if count % 2:
            wrench = np.array([0, 0, 200.0, 0, 0, 0]) + rng.choice([0, 50, 300.0]) * rng.normal(size=6) * (
                [1, 1, 1] * 2
            )
        if nearest(robot, W, wrench)[0] == Status.OK:
            count -= 1
            yield robot, W, wrench


def one_redundant(seed: int, m: int, load: float):
    """A robot with m = n + 1 cables that a positive null vector tightens together, W (m - 1, m)."""
    rng = np.random.default_rng(seed)
    h = rng.uniform(0.2, 1.0, m)
    A = rng.normal(size=(m - 1, m))
    W = np.ascontiguousarray(A - np.outer(A @ h, h) / (h @ h))
    robot = make_robot(crossed_box(rng, m), limits=(LOW, HIGH))
    robot = replace(robot, dof=robot.dof[: m - 1])
    return robot, W, W @ rng.uniform(LOW, 300.0, m) + load * rng.normal(size=m - 1)


def as_published(W, wrench, low, high):
    """Return the answer of Pott's method, by pseudo-inverses of the remainder; None if a tie leaves it open."""
    n, m = W.shape
    free, t = np.ones(m, bool), np.empty(m)
    middle = 0.5 * (low + high)
    rest = wrench.astype(float)
    while free.sum() >= n:
        V = W[:, free]
        t[free] = middle[free] + np.linalg.pinv(V) @ (rest - V @ middle[free])
        beyond = np.maximum(low - t, t - high)
        order = np.argsort(beyond)
        if abs(beyond[order[-1]]) < NEAR or (beyond[order[-2]] > 0 and np.ptp(beyond[order[-2:]]) < NEAR):
            return None, t
        if beyond.max() < 0:
            return True, t
        worst = order[-1]
        t[worst] = low[worst] if t[worst] < low[worst] else high[worst]
        rest = rest - W[:, worst] * t[worst]
        free[worst] = False
    return False, t


@given(seeds, st.integers(6, 12), loads)
def test_improved_closed_form_is_as_published(seed, m, load):
    robot, W, wrench = problem(seed, m, load)
    answered, expected = as_published(W, wrench, robot.tension_min, robot.tension_max)
    if answered is not None:
        status, t = solve("published", robot, W, wrench)
        assert (status == Status.OK) == answered
        if answered:
            np.testing.assert_allclose(t, expected, **CLOSE)


@given(seeds, loads)
def test_the_scaled_rule_is_exact_with_one_redundant_cable(seed, load):
    robot, W, wrench = problem(seed, 7, load)
    if abs(margin(W, wrench, robot.tension_min, robot.tension_max)) > NEAR:
        status, t = solve("scaled", robot, W, wrench)
        exact, expected = nearest(robot, W, wrench)
        assert (status == Status.OK) == (exact == Status.OK)
        if status == Status.OK:
            np.testing.assert_allclose(t, expected, **CLOSE)


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["published", "scaled"])
@pytest.mark.parametrize("m", [7, 8, 9, 12])
@pytest.mark.usual("8-*", "9-*", "12-*")
def test_improved_closed_form_is_nearly_the_exact_nearest_to_the_middle(rule, m):
    answered, equal = 0, 0
    for robot, W, wrench in feasible(m, m, 100):
        status, t = solve(rule, robot, W, wrench)
        if status == Status.OK:
            answered += 1
            equal += np.abs(t - nearest(robot, W, wrench)[1]).max() < 1e-6
    assert answered >= 0.97 * 100
    assert equal >= 0.98 * answered


def test_improved_closed_form_jumps():
    """Its declaration: between two wrenches that differ by 1e-12 the order of fixing changes, and tensions by 100 N."""
    rng = np.random.default_rng(155)
    robot = make_robot(crossed_box(rng, 9), limits=(LOW, HIGH))
    W = kinematics.wrench_matrix(robot, random_state(rng))
    a, b = rng.uniform(LOW, HIGH, (2, 9))

    def at(s):
        status, t = solve("published", robot, W, W @ (a + s * (b - a)))
        return t if status == Status.OK else np.full(9, np.nan)

    samples = np.linspace(0.0, 1.0, 201)
    change = np.nan_to_num([np.abs(at(u) - at(v)).max() for u, v in pairwise(samples)])
    i = int(np.argmax(change))
    low, high = samples[i], samples[i + 1]
    for _ in range(40):
        half = 0.5 * (low + high)
        left, right = np.abs(at(half) - at(low)).max(), np.abs(at(high) - at(half)).max()
        low, high = (low, half) if left >= right else (half, high)
    assert np.abs(at(high) - at(low)).max() > 100.0


@given(seeds, st.integers(6, 12), loads)
def test_puncture_is_the_first_admissible_point_of_the_segment(seed, m, load):
    robot, W, wrench = problem(seed, m, load)
    low, high = robot.tension_min, robot.tension_max
    inverse, middle = np.linalg.pinv(W), 0.5 * (low + high)
    start, end = inverse @ wrench, middle + inverse @ (wrench - W @ middle)
    first, last = 0.0, 1.0
    for a, b, lower, upper in zip(start, end, low, high, strict=True):
        crossings = np.sort([(lower - a) / (b - a), (upper - a) / (b - a)]) if abs(b - a) > 1e-9 else None
        if crossings is not None:
            first, last = max(first, crossings[0]), min(last, crossings[1])
        elif not lower <= a <= upper:
            last = -np.inf
    status, t = solve("puncture", robot, W, wrench)
    if (last - first) * np.abs(end - start).max() > NEAR:
        assert status == Status.OK
        np.testing.assert_allclose(t, start + first * (end - start), rtol=1e-8, atol=1e-6)
    elif last < first - 1e-6:
        assert status != Status.OK


@given(seeds, st.integers(2, 7), st.sampled_from([0.0, 50.0, 500.0]))
def test_kernel_is_exact_with_one_redundant_cable(seed, m, load):
    """All t_0 + lambda h: the interval of lambda that the limits leave is empty, or begins with the answer."""
    robot, W, wrench = one_redundant(seed, m, load)
    h = null_space(W)[:, 0]
    h *= np.sign(h[0])
    start = np.linalg.pinv(W) @ wrench
    first, last = ((robot.tension_min - start) / h).max(), ((robot.tension_max - start) / h).min()
    status, t = solve("kernel", robot, W, wrench)
    if abs(last - first) > NEAR:
        assert status == (Status.OK if first < last else Status.INFEASIBLE)
    if status == Status.OK:
        np.testing.assert_allclose(t, start + first * h, rtol=1e-8, atol=1e-6)


def test_kernel_only_tightens():
    """With limits below zero the pseudo-inverse may do; too high, it would take a negative lambda: not found."""
    robot, W, _ = one_redundant(5, 7, 0.0)
    low, high = np.full(7, -100.0), np.full(7, 100.0)
    wrench = W @ np.linspace(-20.0, 20.0, 7)
    start = np.linalg.pinv(W) @ wrench
    status, t = solve("kernel", robot, W, wrench, low, high)
    assert status == Status.OK
    np.testing.assert_allclose(t, start, atol=1e-9)
    high[np.argmax(start)] = start.max() - 1.0
    assert solve("kernel", robot, W, wrench, low, high)[0] == Status.NOT_FOUND


@given(seeds, st.integers(8, 12))
def test_kernel_supports_no_other_redundancy(seed, m):
    robot, W, wrench = problem(seed, m, 50.0)
    assert solve("kernel", robot, W, wrench)[0] == Status.UNSUPPORTED


def test_kernel_needs_a_null_vector_of_one_sign():
    robot, W, wrench = one_redundant(3, 7, 0.0)
    assert solve("kernel", robot, W, wrench)[0] == Status.OK
    W[:, 2] *= -1.0
    assert solve("kernel", robot, W, wrench)[0] == Status.UNSUPPORTED
    W[:, 2] = np.eye(6)[0]  # six columns of rank 5, so that the null vector leaves this cable alone
    W[0] = np.where(np.arange(7) == 2, 1.0, 0.0)
    assert solve("kernel", robot, W, W @ np.full(7, 50.0))[0] == Status.UNSUPPORTED


@given(seeds, st.integers(7, 12), loads)
def test_dykstra_is_the_exact_nearest_to_the_middle_or_not_found(seed, m, load):
    robot, W, wrench = problem(seed, m, load)
    status, t = solve("dykstra", robot, W, wrench)
    exact, expected = nearest(robot, W, wrench)
    if status == Status.OK:
        assert exact == Status.OK
        np.testing.assert_allclose(t, expected, atol=1e-6)
    else:  # that nothing is feasible it knows where the middle is too far away
        assert status == Status.NOT_FOUND or (status == exact == Status.INFEASIBLE)


def test_dykstra_gives_up_when_requested_and_finds_more_with_patience():
    problems = feasible(1, 8, 100)
    found = [
        sum(solve((Dykstra, DykstraOptions(iterations=k)), *each)[0] == Status.OK for each in problems)
        for k in (1, 50, 500, 5000)
    ]
    assert found == sorted(found)
    assert found[0] < found[1] < found[3]
    assert found[2] >= 85


@given(seeds, st.integers(6, 12), loads, names)
def test_ok_balances_and_infeasible_is_certain(seed, m, load, name):
    robot, W, wrench = problem(seed, m, load)
    low, high = robot.tension_min, robot.tension_max
    status, t = solve(name, robot, W, wrench)
    truth = margin(W, wrench, low, high)
    if status == Status.OK:
        assert np.abs(W @ t - wrench).max() <= 1e-10 * max(1.0, np.abs(t).max())
        assert np.minimum(t - low, high - t).min() >= -1e-6
        assert truth > -NEAR
    elif status == Status.INFEASIBLE:
        assert truth < NEAR


@each_solver
@given(seeds)
def test_locked_cut_and_unequal_cables(name, seed):
    """A locked cable, one that is cut, and what is left with seven: as if they were not there."""
    robot, W, _ = problem(seed, 9, 0.0)
    rng = np.random.default_rng(seed)
    low = rng.uniform(0.0, 50.0, 9)
    high = low + rng.uniform(50.0, 500.0, 9)
    wrench = W @ rng.uniform(low, high)
    low[3] = high[3] = 60.0
    low[5] = high[5] = 0.0
    status, t = solve(name, robot, W, wrench, low, high)
    rest = np.delete(np.arange(9), [3, 5])
    seven = make_robot(crossed_box(rng, 7), limits=(LOW, HIGH))
    V = np.ascontiguousarray(W[:, rest])
    other, left = solve(name, seven, V, wrench - 60.0 * W[:, 3], low[rest], high[rest])
    assert status == other
    if status == Status.OK:
        assert t[3] == 60.0
        assert t[5] == 0.0
        np.testing.assert_allclose(t[rest], left, atol=1e-6)


@each_solver
def test_nothing_to_choose(name):
    """As many cables as freedoms or fewer, or all locked: one answer, or none and certainly so."""
    robot, W, _ = problem(4, 6, 0.0)
    inside = np.linspace(50.0, 300.0, 6)
    for m in (6, 4, 1):
        few = make_robot(crossed_box(np.random.default_rng(0), 6)[:m], limits=(LOW, HIGH))
        V, wrench = np.ascontiguousarray(W[:, :m]), W[:, :m] @ inside[:m]
        status, t = solve(name, few, V, wrench)
        if name == "kernel":
            assert status == Status.UNSUPPORTED
            continue
        assert status == Status.OK
        np.testing.assert_allclose(t, inside[:m], rtol=1e-8)
        assert solve(name, few, V, 20.0 * wrench)[0] == Status.INFEASIBLE
        if m < 6:
            beyond = np.linalg.svd(V)[0][:, -1]
            assert solve(name, few, V, wrench + beyond)[0] == Status.INFEASIBLE
    if name != "kernel":
        status, t = solve(name, robot, W, W @ inside, inside, inside)
        assert status == Status.OK
        np.testing.assert_array_equal(t, inside)
        assert solve(name, robot, W, W @ inside + 1.0, inside, inside)[0] == Status.INFEASIBLE


@each_solver
@given(seeds)
def test_dependent_rows_zero_and_equal_columns(name, seed):
    robot, W, _ = problem(seed, 10, 0.0)
    W[:, 1] = W[:, 0]
    W[:, 2] = 0.0
    W[5] = W[4]
    middle = np.full(10, 255.0)
    status, t = solve(name, robot, W, W @ middle)
    assert status == (Status.UNSUPPORTED if name == "kernel" else Status.OK)
    if status == Status.OK:
        np.testing.assert_allclose(W @ t, W @ middle, atol=1e-8)
        if name != "puncture":
            np.testing.assert_allclose(t, middle, atol=1e-6)
    assert solve(name, robot, W, W @ middle + np.eye(6)[4])[0] == Status.INFEASIBLE


@each_solver
def test_no_wrench_and_no_matrix(name):
    robot, W, _ = problem(2, 8, 0.0)
    zero = np.zeros(6)
    status, t = solve(name, robot, W, zero)
    if status == Status.OK:
        np.testing.assert_allclose(W @ t, 0.0, atol=1e-9)
    status, t = solve(name, robot, np.zeros((6, 8)), zero)
    assert status == (Status.UNSUPPORTED if name == "kernel" else Status.OK)
    assert status != Status.OK or (t.min() >= LOW and t.max() <= HIGH)
    assert solve(name, robot, np.zeros((6, 8)), zero + 1.0)[0] == Status.INFEASIBLE


@each_solver
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_non_finite_values_are_bad_input(name, bad):
    robot, W, wrench = problem(1, 7, 0.0)
    wrong = wrench.copy()
    wrong[2] = bad
    assert solve(name, robot, W, wrong)[0] == Status.BAD_INPUT
    assert solve(name, robot, W, wrench, robot.tension_max, robot.tension_min)[0] == Status.BAD_INPUT
    W[0, 0] = bad
    assert solve(name, robot, W, wrench)[0] == Status.BAD_INPUT
