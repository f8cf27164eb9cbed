"""Which candidate is better, from its figures alone.

Deb's rules (An efficient constraint handling method for genetic algorithms, CMAME 186, 2000): a candidate that keeps
all constraints is better than one that does not; of two that do not, the one that violates them less; of two that do,
the one nearer to the goal, or, of several goals, the one that dominates (Deb et al., NSGA-II, IEEE TEVC 6(2), 2002).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.design.evaluate import Value
from cdpr.design.schema import DesignFile, Limit
from cdpr.model.robot import Array

# Violation of a candidate of which there is no robot, such as one whose lower tension limit is above the upper one:
# beyond what any number of constraints adds up to in practice.
REFUSED = 1e6

# Where optimisers want one number: what violates a constraint is worse than any goal, which stays far below this.
WORSE = 1e30


class Score(NamedTuple):
    """How good a candidate is; less is better in all of it."""

    violation: float  # 0 of one that keeps all constraints
    goals: tuple[float, ...]  # 0 each where it does not

    @property
    def feasible(self) -> bool:
        """Whether it keeps all constraints and has all values that goals ask for."""
        return self.violation == 0.0

    @property
    def scalar(self) -> float:
        """One number for one goal, in the order of Deb's rules."""
        return self.goals[0] if self.feasible else WORSE * (1.0 + self.violation)


def score(section: DesignFile, figures: Mapping[str, Value] | None) -> Score:
    """Return how good a candidate of these figures is; None of one of which there is no robot.

    The violation is the sum of what constraints miss, each over its limit's magnitude (or over 1 where that is 0), and
    of the shares of poses without a value for figures in constraints and goals.
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
    """Return by how much a constraint is missed, 0 where it is kept."""
    if found.value is None:
        return 1.0 + found.missing
    low = _beyond(limit.at_least, found.value, -1.0)
    return low + _beyond(limit.at_most, found.value, 1.0) + found.missing


def _beyond(edge: float | None, value: float, sign: float) -> float:
    if edge is None:
        return 0.0
    return max(0.0, sign * (value - edge)) / (abs(edge) or 1.0)


def dominance(scores: Sequence[Score]) -> NDArray[np.bool_]:
    """Return which of n candidates dominates which, (n, n): [i, j] where i is better than j by the rules above."""
    violation = np.array([each.violation for each in scores])
    goals = np.array([each.goals for each in scores])
    no_worse = (goals[:, None] <= goals[None]).all(axis=2)
    better = (goals[:, None] < goals[None]).any(axis=2)
    less = violation[:, None] < violation[None]
    same = violation[:, None] == violation[None]
    return np.asarray(less | (same & no_worse & better))


def front(scores: Sequence[Score]) -> list[int]:
    """Return the feasible candidates that none dominates, in their order, equal ones once.

    Done one by one against those that are left: a table of all pairs would not fit for many candidates.
    """
    rows = np.array([each.goals for each in scores]).reshape(len(scores), -1)
    kept: list[int] = []
    for i in sorted((k for k, each in enumerate(scores) if each.feasible), key=lambda k: (scores[k].goals, k)):
        if not kept or not (rows[kept] <= rows[i]).all(axis=1).any():
            kept.append(i)
    return sorted(kept)


def select(scores: Sequence[Score], count: int) -> list[int]:
    """Return the best `count` candidates: front by front, and within the last by crowding distance, as NSGA-II does."""
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
    """Return the crowding distances of candidates of one front, (n,), from their goals (n, k)."""
    distance = np.zeros(len(goals))
    for column in goals.T:
        order = np.argsort(column, kind="stable")
        extent = column[order[-1]] - column[order[0]]
        distance[order[[0, -1]]] = np.inf
        if extent > 0.0:
            distance[order[1:-1]] += (column[order[2:]] - column[order[:-2]]) / extent
    return distance


def best(scores: Sequence[Score]) -> int:
    """Return the best candidate, the first of equal ones; of several goals a compromise.

    That is the one of the front nearest to where all goals are at their best, each over its extent on the front.
    """
    several = front(scores) if len(scores[0].goals) > 1 else []
    if not several:
        return min(range(len(scores)), key=lambda k: (scores[k].violation, scores[k].goals, k))
    goals = np.array([scores[i].goals for i in several])
    extent = np.ptp(goals, axis=0)
    shares = (goals - goals.min(axis=0)) / np.where(extent > 0.0, extent, 1.0)
    return several[int(np.argmin(np.linalg.norm(shares, axis=1)))]
