"""Engines of unknown schemes, judged by their limit for a vanishing step: runs with known errors."""

from __future__ import annotations

import numpy as np
import pytest
from compare_cases import load, off

import cdpr
from cdpr.analysis.compare.verdict import against_order


@pytest.fixture(scope="module")
def run():
    return cdpr.simulate(load("rotated_start", {"simulation.duration": 0.2}))


@pytest.mark.parametrize(
    ("share", "outcome"), [(2.0, "agrees"), (1.0, "disagrees"), (4.0, "agrees"), (1.05, "disagrees")]
)
def test_the_limit_of_an_unknown_scheme_is_the_judge(run, share, outcome):
    """Differences that shrink with the step are no fault, even faster than declared; constant ones are."""
    runs = [off(run, "position", [1e-4 / share**k, 0, 0]) for k in range(3)]
    assert against_order(runs, [run] * 3, 1, continuous=True).outcome == outcome


def test_a_fault_hidden_in_the_error_of_the_scheme_is_found(run):
    """A tenth of the finest error does not vanish."""
    runs = [off(run, "position", [1e-4 / 2**k + 2.5e-6, 0, 0]) for k in range(3)]
    verdict = against_order(runs, [run] * 3, 1, continuous=True)
    assert (verdict.outcome, verdict.reason) == ("disagrees", "position beyond its bound")
    assert verdict.checks[0].value == pytest.approx(2.5e-6 * np.sqrt(101 / 201))


def test_an_order_that_is_not_reached_disagrees(run):
    """A fourth-order engine that is late by a step, beside a judge without an error."""
    runs = [off(run, "position", [1e-4 / 2**k, 0, 0]) for k in range(3)]
    verdict = against_order(runs, [run] * 3, 4, continuous=True)
    assert verdict.outcome == "disagrees"


def test_samples_after_a_solver_failure_are_not_judged(run):
    """There tensions may jump: the limit is that of the samples before."""
    for first, outcome in ((120, "agrees"), (5, "not judged")):
        lost = off(run, "status", 1, slice(first, None))
        runs = [off(lost, "position", [1e-4, 0, 0], slice(first + 1, None))] * 3
        assert against_order(runs, [lost] * 3, 1, continuous=True).outcome == outcome


def test_a_judge_with_an_error_as_large_judges_nothing(run):
    judges = [off(run, "position", [0, 4e-4 / 2**k, 0]) for k in range(3)]
    runs = [off(run, "position", [1e-4 / 2**k, 0, 0]) for k in range(3)]
    verdict = against_order(runs, judges, 1, continuous=True)
    assert verdict.outcome == "not judged"
    assert "estimated error of reference is as large as the difference" in verdict.reason
