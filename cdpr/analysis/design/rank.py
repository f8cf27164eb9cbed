"""Ranking of candidates by their figures.

Deb's rules (An efficient constraint handling method for genetic algorithms, CMAME 186, 2000): a candidate that
satisfies all constraints is better than one that does not. Of two infeasible candidates, the smaller violation is
better. Of two feasible ones, the better goal or, with several goals, the dominating candidate is better (Deb et al.,
NSGA-II, IEEE TEVC 6(2), 2002).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.design.evaluate import Value
from cdpr.analysis.design.schema import DesignFile, Limit
from cdpr.model.robot import Array

# Violation of invalid robots, such as with a lower tension limit above the upper one; larger than any sum of constraint
# violations in practice.
REFUSED = 1e6

# Offset of infeasible candidates for single-objective optimisers: larger than any goal.
WORSE = 1e30


class Score(NamedTuple):
    """Score of a candidate; smaller is better."""

    violation: float  # 0 if all constraints are satisfied
    goals: tuple[float, ...]  # all 0 if they are not

    @property
    def feasible(self) -> bool:
        """True if all constraints are satisfied and all goals have values."""
        return self.violation == 0.0

    @property
    def scalar(self) -> float:
        """Single number for one goal, in the order of Deb's rules."""
        return self.goals[0] if self.feasible else WORSE * (1.0 + self.violation)


def score(section: DesignFile, figures: Mapping[str, Value] | None) -> Score:
    """Return the score of a candidate with these figures; None means an invalid robot.

    The violation is the sum over the constraints, each divided by its limit's magnitude (or by 1 if that is 0), plus
    the shares of poses without a value for figures in constraints and goals.
    """
    nothing = (0.0,) * len(section.wanted)
    if figures is None:
        return Score(REFUSED, nothing)
    violation = sum(missed(limit, figures[limit.figure]) for limit in section.constraints)
    goals = []
    for goal in section.wanted:
        total = 0.0
        for term in goal.terms:
            found = figures[term.figure]
            violation += found.missing
            total += term.weight * (found.value or 0.0) / term.scale
        goals.append(total if goal.minimise is not None else -total)
    return Score(violation, tuple(goals)) if violation == 0.0 else Score(violation, nothing)


def missed(limit: Limit, found: Value) -> float:
    """Return the violation of a constraint; 0 if it is satisfied."""
    if found.value is None:
        return 1.0 + found.missing
    low = _beyond(limit.at_least, found.value, -1.0)
    return low + _beyond(limit.at_most, found.value, 1.0) + found.missing


def _beyond(edge: float | None, value: float, sign: float) -> float:
    if edge is None:
        return 0.0
    return max(0.0, sign * (value - edge)) / (abs(edge) or 1.0)


def dominance(scores: Sequence[Score]) -> NDArray[np.bool_]:
    """Return the dominance matrix (n, n): element [i, j] is True if candidate i is better than j by the rules above."""
    violation = np.array([each.violation for each in scores])
    goals = np.array([each.goals for each in scores])
    no_worse = (goals[:, None] <= goals[None]).all(axis=2)
    better = (goals[:, None] < goals[None]).any(axis=2)
    less = violation[:, None] < violation[None]
    same = violation[:, None] == violation[None]
    return np.asarray(less | (same & no_worse & better))


def front(scores: Sequence[Score]) -> list[int]:
    """Return the indices of the feasible non-dominated candidates, in their order; of equal ones only the first.

    Candidates are compared one by one: a table of all pairs would not fit into memory for many candidates.
    """
    rows = np.array([each.goals for each in scores]).reshape(len(scores), -1)
    kept: list[int] = []
    for i in sorted((k for k, each in enumerate(scores) if each.feasible), key=lambda k: (scores[k].goals, k)):
        if not kept or not (rows[kept] <= rows[i]).all(axis=1).any():
            kept.append(i)
    return sorted(kept)


def select(scores: Sequence[Score], count: int) -> list[int]:
    """Return the best `count` candidates, front by front, and within the last by crowding distance (NSGA-II)."""
    over = dominance(scores)
    left = np.arange(len(scores))
    chosen: list[int] = []
    while len(chosen) < count:
        first = left[~over[np.ix_(left, left)].any(axis=0)]
        room = count - len(chosen)
        if len(first) > room:
            lonely = crowding(np.array([scores[i].goals for i in first]))
            first = first[np.argsort(-lonely, kind="stable")[:room]]
        chosen += first.tolist()
        left = np.setdiff1d(left, first)
    return chosen


def crowding(goals: Array) -> Array:
    """Return the crowding distances (n,) of candidates of one front from their goals (n, k)."""
    distance = np.zeros(len(goals))
    for column in goals.T:
        order = np.argsort(column, kind="stable")
        extent = column[order[-1]] - column[order[0]]
        distance[order[[0, -1]]] = np.inf
        if extent > 0.0:
            distance[order[1:-1]] += (column[order[2:]] - column[order[:-2]]) / extent
    return distance


def best(scores: Sequence[Score]) -> int:
    """Return the index of the best candidate, the first of equal ones; with several goals a compromise.

    The compromise is the point of the front closest to the ideal point, with each goal scaled by its range on the
    front.
    """
    several = front(scores) if len(scores[0].goals) > 1 else []
    if not several:
        return min(range(len(scores)), key=lambda k: (scores[k].violation, scores[k].goals, k))
    goals = np.array([scores[i].goals for i in several])
    extent = np.ptp(goals, axis=0)
    shares = (goals - goals.min(axis=0)) / np.where(extent > 0.0, extent, 1.0)
    return several[int(np.argmin(np.linalg.norm(shares, axis=1)))]
