"""The solvers over the null space: linear programs, analytic centre, options of qp, best effort."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import crossed_box, make_robot
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import null_space
from scipy.optimize import linprog, lsq_linear
from tension_operations import box_least_squares
from test_qp import CERTAIN, RESIDUAL, loads, margin, problem, seeds

from cdpr.base.errors import PluginError
from cdpr.plugins.registry import registry
from cdpr.tension import Status

pytestmark = pytest.mark.core

LIMIT = 500.0  # N, of these problems
GAP = 1e-9  # relative: HiGHS's own tolerance is 1e-7, its vertices are exact to round-off
STATIONARY = 1e-7  # of the barrier's gradient against that of its largest term


def made(name, robot, **options):
    entry = registry().get("solver", name)
    return entry.make(robot, entry.read_options(options))


def ask(name, robot, W, wrench, previous=None, **options):
    tension = np.full(robot.m, np.nan) if previous is None else np.array(previous)
    status = made(name, robot, **options).solve(W, wrench, robot.tension_min, robot.tension_max, tension)
    return status, tension


@pytest.mark.parametrize("name", ["lp", "maximin", "analytic_centre", "best_effort"])
@given(seed=seeds, m=st.integers(6, 12), load=loads)
def test_answers_where_there_is_one_and_only_there(name, seed, m, load):
    robot, W, wrench = problem(seed, m, load)
    status, t = ask(name, robot, W, wrench)
    truth = margin(W, wrench, robot.tension_min, robot.tension_max)
    assert status in (Status.OK, Status.INFEASIBLE)
    if abs(truth) > CERTAIN * LIMIT:
        assert (status == Status.OK) == (truth > 0.0)
    if status == Status.OK:
        assert np.abs(W @ t - wrench).max() <= RESIDUAL * max(1.0, np.abs(t).max(), np.abs(wrench).max())
        assert np.all((t >= robot.tension_min) & (t <= robot.tension_max))


@given(seeds, st.integers(7, 12), loads)
def test_linear_programs_reach_the_optimum_of_highs(seed, m, load):
    robot, W, wrench = problem(seed, m, load)
    low, high = robot.tension_min, robot.tension_max
    status, t = ask("lp", robot, W, wrench)
    if status == Status.OK:
        best = linprog(np.ones(m), A_eq=W, b_eq=wrench, bounds=list(zip(low, high, strict=True)))
        assert t.sum() == pytest.approx(best.fun, rel=GAP)
        _, t = ask("maximin", robot, W, wrench)
        truth = margin(W, wrench, low, high)
        assert min((t - low).min(), (high - t).min()) == pytest.approx(truth, abs=CERTAIN * LIMIT)
        weights = np.random.default_rng(seed).uniform(0.2, 5.0, m)
        _, t = ask("lp", robot, W, wrench, weights=weights.tolist())
        best = linprog(weights, A_eq=W, b_eq=wrench, bounds=list(zip(low, high, strict=True)))
        assert weights @ t == pytest.approx(best.fun, rel=GAP)


@given(seeds, st.integers(7, 10), loads)
def test_ball_is_the_chebyshev_centre(seed, m, load):
    robot, W, wrench = problem(seed, m, load)
    low, high = robot.tension_min, robot.tension_max
    status, t = ask("maximin", robot, W, wrench, norm="ball")
    if status == Status.OK:
        size = np.linalg.norm(null_space(W), axis=1)
        radius = min(((t - low) / size).min(), ((high - t) / size).min())
        zero = np.zeros((len(W), 1))
        rows = np.block([[-np.eye(m), size[:, None]], [np.eye(m), size[:, None]]])
        best = linprog(
            [0.0] * m + [-1.0],
            rows,
            np.concatenate([-low, high]),
            np.hstack([W, zero]),
            wrench,
            [(None, None)] * (m + 1),
        )
        assert radius == pytest.approx(-best.fun, abs=CERTAIN * LIMIT)


def test_of_several_linear_optima_the_least_norm():
    """Two equal cables carry a load together in equal parts, though any split costs the same."""
    robot = make_robot(np.array([[0, 0, 3, 0, 0, 0], [0, 0, 3.0, 0, 0, 0], [0, 0, -3, 0, 0, 0]]), limits=(1.0, 100.0))
    robot = replace(robot, dof=("z",))
    W = np.array([[1.0, 1.0, -1.0]])
    tension = np.zeros(3)
    for name in ("lp",):
        status = made(name, robot).solve(W, np.array([30.0]), robot.tension_min, robot.tension_max, tension)
        assert status == Status.OK
        np.testing.assert_allclose(tension, [15.5, 15.5, 1.0], atol=1e-12)


@given(seeds, st.integers(7, 12), st.booleans())
def test_analytic_centre_is_stationary(seed, m, weighted):
    robot, W, wrench = problem(seed, m, 50.0)
    weights = np.random.default_rng(seed).uniform(0.2, 5.0, m) if weighted else np.ones(m)
    status, t = ask("analytic_centre", robot, W, wrench, **({"weights": weights.tolist()} if weighted else {}))
    if status == Status.OK and margin(W, wrench, robot.tension_min, robot.tension_max) > 1e-3:
        below, above = weights / (t - robot.tension_min), weights / (robot.tension_max - t)
        gradient = null_space(W).T @ (above - below)
        assert np.abs(gradient).max() <= STATIONARY * np.maximum(below, above).max()


@given(seeds, st.integers(7, 10), st.sampled_from(["middle", "given", "previous"]), st.booleans())
def test_qp_about_a_reference_and_weighted(seed, m, about, weighted):
    """The optimum (KKT): t = ref + W^T y / w, clipped to the limits; the cables inside them determine y."""
    robot, W, wrench = problem(seed, m, 50.0)
    rng = np.random.default_rng(seed)
    reference = rng.uniform(10.0, 500.0, m)
    weights = rng.uniform(0.2, 5.0, m) if weighted else np.ones(m)
    options = {"about": about}
    if weighted:
        options["weights"] = weights.tolist()
    if about == "given":
        options["reference"] = reference.tolist()
    status, t = ask("qp", robot, W, wrench, previous=reference if about == "previous" else None, **options)
    if about == "middle":
        reference = np.full(m, 255.0)
    low, high = robot.tension_min, robot.tension_max
    if status == Status.OK:
        free = (t > low + 1e-6) & (t < high - 1e-6)
        if np.linalg.matrix_rank(W[:, free], 1e-6) == 6:
            y = np.linalg.lstsq(W[:, free].T, (weights * (t - reference))[free], rcond=None)[0]
            np.testing.assert_allclose(np.clip(reference + W.T @ y / weights, low, high), t, atol=1e-6)


def test_qp_limits_the_change_of_a_step():
    robot, W, _ = problem(4, 8, 0.0)
    before = np.linspace(100.0, 300.0, 8)
    wrench = W @ (before + np.linspace(-4.0, 4.0, 8))
    status, t = ask("qp", robot, W, wrench, previous=before, change=5.0)
    assert status == Status.OK
    assert np.abs(t - before).max() <= 5.0 + 1e-12
    free_status, free = ask("qp", robot, W, wrench, previous=before)
    assert free_status == Status.OK
    assert np.abs(free - before).max() > 5.0
    far = W @ (before + 150.0 * np.sign(np.linspace(-1, 1, 8)))
    assert ask("qp", robot, W, far, previous=before, change=1.0)[0] == Status.NOT_FOUND
    status, first = ask("qp", robot, W, wrench, change=5.0)  # nothing is previous: nothing is limited
    assert status == Status.OK
    np.testing.assert_array_equal(first, free)


@pytest.mark.parametrize(
    ("name", "options", "text"),
    [
        ("qp", {"about": "given"}, "reference: is for"),
        ("qp", {"weights": [1.0, 2.0]}, "weights: expected one number per cable, 8"),
        ("qp", {"about": "mid"}, "option about"),
        ("lp", {"weights": [0.0] * 8}, "greater than 0"),
        ("maximin", {"nrom": "ball"}, "its options are norm"),
    ],
)
def test_wrong_options_are_reported(name, options, text):
    robot = make_robot(crossed_box(np.random.default_rng(0), 8))
    with pytest.raises(PluginError, match=text):
        made(name, robot, **options)


@given(seeds, st.integers(1, 12), loads, st.integers(2, 6))
def test_best_residual_is_reached_and_nothing_jumps_at_the_boundary(seed, m, load, n):
    """Within 1e-8 of the load of scipy's optimum, for any shape; equal columns and locked cables included."""
    robot, W, wrench = problem(seed, m, load)
    W, wrench = np.ascontiguousarray(W[:n]), np.ascontiguousarray(wrench[:n])
    if seed % 3 == 0 and m > 1:
        W[:, 1] = W[:, 0]
    low, high = robot.tension_min.copy(), robot.tension_max.copy()
    if seed % 5 == 0:
        low[-1] = high[-1] = 20.0
    weights = np.array([1, 1, 1, 4.0, 4.0, 4.0])[:n]
    t = np.zeros(m)
    assert box_least_squares(W, wrench, weights, low, high, t) >= 0
    assert np.all((t >= low) & (t <= high))
    rows, wanted = weights[:, None] * W, weights * wrench
    if m > 1 or low[-1] < high[-1]:
        open_ = low < high
        rest = wanted - rows[:, ~open_] @ low[~open_]
        best = lsq_linear(rows[:, open_], rest, (low[open_], high[open_]), method="bvls", tol=1e-15, max_iter=1000)
        ours = np.linalg.norm(rows @ t - wanted)
        assert ours <= np.linalg.norm(best.fun) + 1e-8 * max(1.0, np.linalg.norm(wanted))


def test_best_effort_is_continuous_across_the_boundary():
    robot, W, wrench = problem(8, 8, 50.0)

    def largest(samples):
        scales = np.linspace(0.0, 8.0, samples)
        answers = [ask("best_effort", robot, W, scale * wrench) for scale in scales]
        assert {status for status, _ in answers} == {Status.OK, Status.INFEASIBLE}
        return float(np.abs(np.diff([t for _, t in answers], axis=0)).max())

    coarse = largest(201)
    assert largest(2001) < 0.2 * coarse


@pytest.mark.parametrize("name", ["qp", "lp", "maximin", "analytic_centre", "best_effort", "centroid"])
def test_cut_cable_takes_nothing_and_the_others_carry_on(name):
    robot, W, _ = problem(21, 8, 0.0)
    low, high = robot.tension_min.copy(), robot.tension_max.copy()
    inside = np.random.default_rng(3).uniform(100.0, 300.0, 8)
    inside[2] = low[2] = high[2] = 0.0
    tension = np.zeros(8)
    assert made(name, robot).solve(W, W @ inside, low, high, tension) == Status.OK
    assert tension[2] == 0.0
    np.testing.assert_allclose(W @ tension, W @ inside, atol=1e-9)
