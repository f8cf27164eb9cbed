"""Closed form and pseudo-inverse in the kernel library: instruction sets, lanes, functions."""

from __future__ import annotations

import kernel_cases
import numpy as np
import pytest
from kernel_cases import assert_same_bits, run, run_lanes, targets_of
from solver_kernel_cases import EACH, problems

from cdpr.tension.status import Status
from cdpr_solvers.closed_form import closed_form_tension
from cdpr_solvers.pseudo_inverse import pseudo_inverse_tension
from cdpr_solvers.qp import ABOUT

SHAPES = [(1, 2), (2, 3), (3, 5), (6, 8), (6, 6), (4, 16)]


@pytest.mark.parametrize("name", ["closed_form", "pseudo_inverse", "minimum_norm"])
def test_each_lane_has_the_bits_and_the_status_that_it_has_alone(name):
    rng, statuses = np.random.default_rng(1), np.zeros(5, dtype=int)
    for n, m in SHAPES:
        inputs, shapes = problems(rng, n, m), {"tension": (m,), "status": (1,)}
        values, before = {}, {}
        if name == "minimum_norm":
            values = {"about": ABOUT["previous"], "change": np.inf, "weighted": 0}
            before = {"tension": np.full((EACH, m), np.nan)}
            inputs |= {"reference": np.zeros((EACH, m)), "root": np.ones((EACH, m))}
        found, codes = run(name, inputs, shapes, before, **values)
        lanes, groups = run_lanes(name, inputs, shapes, before, **values)
        answered = codes == Status.OK
        assert lanes["status"][:, 0].tolist() == found["status"][:, 0].tolist() == codes.tolist()
        assert_same_bits(lanes["tension"][answered], found["tension"][answered])
        assert [group >> lane & 1 for group in groups for lane in range(8)] == (~answered).astype(int).tolist()
        statuses += np.bincount(codes, minlength=5)
    assert (statuses[[Status.OK, Status.INFEASIBLE, Status.BAD_INPUT]] > 10).all()


@pytest.mark.parametrize("go", [run, run_lanes])
def test_an_answer_that_differs_between_instruction_sets_is_found(monkeypatch, go):
    here = targets_of("closed_form_lanes" if go is run_lanes else "closed_form")
    if len(here) == 1:
        pytest.skip("this processor has one instruction set")

    def with_a_newton(target, *given):
        answers, codes = run_on(target, *given)
        if target == here[0]:
            k = np.flatnonzero(answers["status"].reshape(len(codes), -1)[:, 0] == Status.OK)[0]
            answers["tension"][k].flat[0] += 1.0
        return answers, codes

    run_on, inputs = kernel_cases._run_on, problems(np.random.default_rng(1), 3, 5)
    go("closed_form", inputs, {"tension": (5,), "status": (1,)})
    monkeypatch.setattr(kernel_cases, "_run_on", with_a_newton)
    with pytest.raises(AssertionError):
        go("closed_form", inputs, {"tension": (5,), "status": (1,)})


def test_functions_match_their_docstrings():
    W = np.array([[1.0, -1.0, 0.5], [0.2, 0.3, -1.0]])
    t = np.array([30.0, 20.0, 25.0])
    low, high = np.full(3, 1.0), np.full(3, 100.0)
    tension, status = closed_form_tension(W, W @ t, low, high)
    middle = 0.5 * (low + high)
    np.testing.assert_allclose(tension, middle + np.linalg.pinv(W) @ (W @ t - W @ middle))
    assert status == Status.OK
    tension, status = pseudo_inverse_tension(W, W @ t, low, high)
    np.testing.assert_allclose(tension, np.linalg.pinv(W) @ W @ t)
    tension, status = closed_form_tension(W, W @ t, low, [100.0, np.inf, 100.0])
    assert status == Status.UNSUPPORTED
    assert np.isnan(tension).all()
    assert closed_form_tension(W, [np.nan, 0.0], low, high)[1] == Status.BAD_INPUT
    with pytest.raises(ValueError, match=r"closed_form: wrench: expected shape \(n,\)"):
        closed_form_tension(W, [1.0, 2.0, 3.0], low, high)
