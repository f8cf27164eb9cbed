"""Adversarial problems: rational arithmetic proves the declared property of each."""

from __future__ import annotations

import re

import bench_cases as cases
import numpy as np
import pytest
from bench_cases import plugin, plugins, wall

from cdpr.analysis.bench import run
from cdpr.analysis.bench.adversaries import BAND, adversaries, certify, robots
from cdpr.analysis.bench.measures import accuracy, judge
from cdpr.analysis.bench.oracle import certified
from cdpr.analysis.bench.overview import overview
from cdpr.analysis.bench.problems import hard_problems
from cdpr.analysis.bench.solver_calls import Answers
from cdpr.tension import Status
from cdpr.ui.report.pages.bench import MISLEADING
from cdpr_solvers.qp import MinimumNorm

COUNT = 90


@pytest.fixture(scope="module")
def families():
    return [adversaries(robot, COUNT, 1) for robot in robots()]


@pytest.mark.slow
def test_each_is_certified(families):
    for family in families:
        for k in range(0, COUNT, 2):
            share = certify(family, k)
            if family.feasible[k]:
                assert share == pytest.approx(family.slack[k], abs=1e-15) or np.isinf(family.slack[k])
            else:
                assert share > BAND


def test_a_false_certificate_is_refused(families):
    family = adversaries(robots()[3], 6, 1)
    family.solution[0] *= 1.0 + 1e-15
    with pytest.raises(AssertionError):
        certify(family, 0)
    family.certificate[2] *= -1.0
    with pytest.raises(AssertionError):
        certify(family, 2)


def test_all_kinds_are_there(families):
    """The description on the page is correct."""
    kinds = " ".join(text for family in families for text in family.kind)
    for word in ("parallel", "opposite", "twins", "nearly parallel", "zero column", "zero row", "dependent rows"):
        assert word in kinds
    for word in ("long arms", "at limits", "locked", "sliver", "narrow"):
        assert word in kinds
    largest = np.concatenate([family.high.max(axis=1) for family in families])
    assert largest.min() < 3e-3
    assert largest.max() > 3e5
    slack = np.concatenate([family.slack for family in families])
    assert np.nanmin(slack[slack > 0.0]) < 1e-11
    assert (slack == 0.0).any()
    assert all(0.3 < 1.0 - family.feasible.mean() < 0.4 for family in families)


def test_problem_k_does_not_depend_on_their_number(families):
    fewer = adversaries(robots()[2], 10, 1)
    np.testing.assert_array_equal(fewer.W, families[2].W[:10])
    np.testing.assert_array_equal(fewer.wrench, families[2].wrench[:10])
    assert not np.array_equal(adversaries(robots()[2], 10, 2).W, fewer.W)


def answers(family, status, tension):
    count = np.ones(len(family), dtype=np.int64)
    return Answers(np.full(len(family), status, dtype=np.int64), tension, count, count)


def test_the_page_matches_the_verdict(families):
    family = families[4]
    problems, oracle = hard_problems(family), certified(family)
    said = answers(family, Status.INFEASIBLE, np.full_like(family.low, np.nan))
    figures = accuracy(problems, oracle, said, {})
    assert figures["misclassified"] == oracle.feasible.sum() == (family.slack > BAND).sum()
    assert figures["edge_coverage"] == figures["coverage"] == 0.0
    true = np.where(family.feasible[:, None], family.solution, 0.0)
    figures = accuracy(problems, oracle, answers(family, Status.OK, true), {})
    assert figures["misclassified"] == (~family.feasible).sum()
    assert figures["coverage"] == figures["edge_coverage"] == 1.0
    # A hundred-thousandth too much is seen in millinewtons, too.
    off = judge(problems, answers(family, Status.OK, true * (1.0 + 1e-5)))
    assert not off.valid[(np.abs(family.wrench).max(axis=1) > 0.5 * family.high.max(axis=1))].any()
    assert re.search(rf"narrowed by {BAND:g} of the largest tension", MISLEADING)


class Remembering(MinimumNorm):
    """If its work space contained a number, it would start from that number."""

    def solve(self, W, wrench, t_min, t_max, tension):
        stale = float(self.work[-1].flat[-1])
        status = super().solve(W, wrench, t_min, t_max, tension)
        if stale == 1e30:
            tension *= 1.001
        return status


@pytest.mark.slow
def test_bench_finds_wrong_answers_and_counts_them():
    found = run(
        [wall()],
        None,
        5,
        adversaries=30,
        plugins=plugins(
            plugin(MinimumNorm, "sound"), plugin(cases.AlwaysOk, "lying"), plugin(Remembering, "remembering")
        ),
    )
    assert len(found["adversaries"]) == len(robots())
    rows = {row["name"]: row for row in overview(found)}
    assert (rows["sound"]["misclassified"], rows["sound"]["invalid_ok"]) == (0, 0)
    assert rows["sound"]["asked"] == 5 + 30 * len(robots())
    assert rows["lying"]["misclassified"] >= 10 * len(robots())
    assert rows["remembering"]["invalid_ok"] > 0
