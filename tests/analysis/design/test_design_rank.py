"""Ranking of candidates: Deb's rules, fronts, crowding, and sizes of violations."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from design_cases import BOX, ONE, design_of

from cdpr.analysis.design.evaluate import Value
from cdpr.analysis.design.rank import REFUSED, Score, best, crowding, dominance, front, score, select

SUM = """
goal: {maximise: [{figure: volume, weight: 2, scale: 10}, {figure: clearance, weight: -1}]}
constraints: [{figure: width, at_least: 2, at_most: 4}, {figure: clearance, at_least: 0}]
"""


def figures(volume=5.0, clearance=0.1, width=3.0, missing=0.0):
    return {"volume": Value(volume), "clearance": Value(clearance, missing), "width": Value(width)}


def test_a_weighted_sum_and_what_violates(tmp_path):
    section = design_of(tmp_path, BOX + SUM).section
    assert section.wanted[0].label == "maximise 2 volume / 10 - 1 clearance"
    assert score(section, figures()) == Score(0.0, (-(2 * 5.0 / 10 - 0.1),))
    assert score(section, figures(width=5.0)) == Score(0.25, (0.0,))
    assert score(section, figures(width=1.0)).violation == 0.5
    assert score(section, figures(clearance=-0.3)).violation == 0.3, "a limit of 0 has no magnitude: in m"
    both = score(section, figures(width=5.0, clearance=-0.3)).violation
    assert both == pytest.approx(0.55)
    assert score(section, figures(missing=0.25)).violation == 0.5, "once in the goal, once in the constraint"
    assert score(section, {**figures(), "width": Value(None, 1.0)}).violation == 2.0
    assert score(section, None) == Score(REFUSED, (0.0,))


def test_one_number_has_the_order_of_the_rules(tmp_path):
    section = design_of(tmp_path).section
    order = [
        score(section, figures(volume=9.0)),
        score(section, figures(volume=2.0)),
        score(section, figures(volume=99.0, clearance=0.0199999999999)),
        score(section, figures(volume=1.0, clearance=0.01)),
        score(section, figures(volume=9.0, clearance=-1.0)),
        score(section, None),
    ]
    numbers = [each.scalar for each in order]
    assert numbers == sorted(numbers)
    assert len(set(numbers)) == 6
    assert np.isfinite(numbers).all()


def better(a, b):
    if a.violation != b.violation:
        return a.violation < b.violation
    return all(x <= y for x, y in zip(a.goals, b.goals, strict=True)) and a.goals != b.goals


def some(count, goals=2):
    rng = np.random.default_rng(count)
    rows, kinds = rng.integers(0, 6, (count, goals)).astype(float).tolist(), rng.integers(0, 3, count)
    return [Score(float(v), tuple(g) if v == 0 else (0.0,) * goals) for v, g in zip(kinds, rows, strict=True)]


def test_dominance_and_fronts_by_the_definition():
    for goals in (1, 2, 3):
        scores = some(60, goals)
        over = dominance(scores)
        for i, j in itertools.product(range(60), repeat=2):
            assert over[i, j] == better(scores[i], scores[j])
        free = [i for i in range(60) if scores[i].feasible and not over[:, i].any()]
        found = front(scores)
        assert {scores[i].goals for i in found} == {scores[i].goals for i in free}
        assert len(found) == len({scores[i].goals for i in free}), "equal ones once"
        assert found == sorted(found)
    assert front([Score(1.0, (0.0, 0.0))]) == []


def test_a_selection_takes_the_first_fronts_and_the_lonely():
    line = [Score(0.0, (float(k), 10.0 - k)) for k in (0, 1, 2, 3, 10)]
    worse = [Score(0.0, (11.0, 11.0)), Score(1.0, (0.0, 0.0)), Score(0.5, (0.0, 0.0))]
    assert sorted(select([*worse, *line], 6)) == [0, 3, 4, 5, 6, 7]
    assert sorted(select([*worse, *line], 7)) == [0, 2, 3, 4, 5, 6, 7], "the less violated of two"
    assert sorted(select(line, 3)) == [0, 3, 4], "both ends, and the one that is farthest from its neighbours"
    assert sorted(select([*worse, *line], 8)) == list(range(8))


def test_crowding():
    found = crowding(np.array([[0.0, 4.0], [1.0, 2.0], [4.0, 0.0], [2.0, 1.0]]))
    assert found[[0, 2]].tolist() == [math.inf, math.inf]
    assert found[1] == pytest.approx(2.0 / 4.0 + 3.0 / 4.0)
    assert found[3] == pytest.approx(3.0 / 4.0 + 2.0 / 4.0)


def test_the_best():
    assert best([Score(0.1, (0.0,)), Score(0.0, (3.0,)), Score(0.0, (2.0,)), Score(0.0, (2.0,))]) == 2
    assert best([Score(0.3, (0.0,)), Score(0.2, (0.0,))]) == 1
    corner = [Score(0.0, (0.0, 10.0)), Score(0.0, (3.0, 2.0)), Score(0.0, (10.0, 0.0)), Score(0.0, (9.0, 9.0))]
    assert best(corner) == 1
    assert best([Score(0.5, (0.0, 0.0)), Score(0.4, (0.0, 0.0))]) == 1


def test_the_constraints_of_the_example(tmp_path):
    assert [limit.label for limit in design_of(tmp_path, BOX + ONE).section.constraints] == [
        "0.02 <= clearance",
        "width <= 4.2",
    ]
