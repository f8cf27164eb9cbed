"""Minimum 2-norm or 1-norm within the limits in rational arithmetic, slow and exact."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from math import lcm
from operator import mul
from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.rank import RANK_TOLERANCE
from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.tension import Status

Vector = list[Fraction]
Rows = list[list[int]]  # integers need no common divisors, which make up most of the cost of fractions

# Largest residual of the wrench in a dependent row, as a share of the largest load, for the row to be consistent.
CONSISTENCY_TOLERANCE = 1e-9

# First step of the linear program, in units of the largest limit: so long that it mostly ends at the optimum.
LONG_STEP = 2**20


class Exact(TensionSolver):
    """Exact optimum of the problem as stated by its floating-point numbers, each tension rounded once.

    It verifies other solvers, as the exact program of CGAL did in the thesis. It works for any number of cables. The
    2-norm takes about a millisecond for eight cables, the 1-norm several. Rows of W that depend on others up to
    round-off (RANK_TOLERANCE) are not separate equations. Feasibility is decided exactly. `one_norm` minimises the sum
    of the tensions and returns one optimum if there are several.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        super().__init__(robot, options)
        self._linear = options is not None and options.objective == "one_norm"

    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the distribution into `tension` (m,)."""
        if not all(np.isfinite(array).all() for array in (W, wrench)) or not (t_min <= t_max).all():
            return Status.BAD_INPUT
        if not (np.isfinite(t_min).all() and np.isfinite(t_max).all()):
            return Status.UNSUPPORTED
        free = t_min < t_max
        kept = no_round_off(W[:, free], wrench - W[:, ~free] @ t_min[~free], np.abs(W[:, ~free] * t_min[~free]))
        if kept is None:
            return Status.INFEASIBLE
        tension[:] = t_min
        locked = fractions(t_min[~free])
        rows = []
        for j in kept:
            left = Fraction(float(wrench[j])) - dot(fractions(W[j, ~free]), locked)
            rows.append(whole([*fractions(W[j, free]), left]))
        equations = independent(rows)
        if equations is None:
            return Status.INFEASIBLE
        matrix, right = [row[:-1] for row in equations], [row[-1] for row in equations]
        find = least_sum if self._linear else least_norm
        answer = find(matrix, right, fractions(t_min[free]), fractions(t_max[free])) if free.any() else []
        if answer is None:
            return Status.INFEASIBLE
        tension[free] = [float(t) for t in answer]
        return Status.OK


def fractions(values: Iterable[float]) -> Vector:
    """Return the numbers as fractions without rounding."""
    return [Fraction(float(x)) for x in values]


def whole(values: Iterable[float | Fraction]) -> list[int]:
    """Return the numbers times their common denominator."""
    exact = [Fraction(x) for x in values]
    unit = lcm(*(x.denominator for x in exact))
    return [x.numerator * (unit // x.denominator) for x in exact]


def no_round_off(V: Array, right: Array, given: Array) -> list[int] | None:
    """Return the rows of V t = right, V (n, k), that exceed the round-off of the others, in ascending order.

    It returns None if the other rows contradict them; `given` are the loads that made `right`. Rows that depend on
    others up to RANK_TOLERANCE would be separate constraints in exact arithmetic, due to rounding alone.
    """
    load = max(float(np.abs(right).max(initial=0.0)), float(given.max(initial=0.0)))
    largest = float(np.abs(V).max(initial=0.0))
    unit = math.ldexp(1.0, math.frexp(largest)[1]) if largest > 0.0 else 1.0  # prevents an overflow of squares
    rest = np.column_stack([V / unit, right / load if load > 0.0 else right])
    kept: list[int] = []
    left, first = list(range(len(V))), 0.0
    while left and V.shape[1]:
        norms = [float(np.linalg.norm(rest[j, :-1])) for j in left]
        k = int(np.argmax(norms))
        first = first or norms[k]
        if not norms[k] > RANK_TOLERANCE * first:
            break
        kept.append(left.pop(k))
        row = rest[kept[-1]] / norms[k]
        for j in left:
            rest[j] -= (rest[j, :-1] @ row[:-1]) * row
    if any(abs(rest[j, -1]) > CONSISTENCY_TOLERANCE for j in left):
        return None
    return sorted(kept)


def independent(equations: Rows) -> Rows | None:
    """Return the linearly independent rows [W_j, wrench_j], None if the rows contradict each other."""
    kept: Rows = []
    reduced: list[tuple[list[int], int]] = []
    for equation in equations:
        rest, divisor = equation, 1
        for row, pivot in reduced:
            rest = eliminated(rest, row, pivot, divisor)
            divisor = row[pivot]
        first = next((i for i, entry in enumerate(rest) if entry), None)
        if first == len(rest) - 1:  # 0 = non-zero
            return None
        if first is not None:
            reduced.append((rest, first))
            kept.append(equation)
    return kept


def eliminated(row: list[int], by: list[int], pivot: int, divisor: int) -> list[int]:
    """Return the row with a zero at `pivot`; the previous pivot divides it without remainder (Bareiss 1968)."""
    a, b = by[pivot], row[pivot]
    return [(a * x - b * y) // divisor for x, y in zip(row, by, strict=True)]


def solution(A: Rows, right: Sequence[Fraction | int]) -> tuple[list[int], int]:
    """Return the numerators and the common denominator of x with A x = right, A square and positive definite."""
    unit = lcm(*(x.denominator for x in right))
    rows = [[*row, x.numerator * (unit // x.denominator)] for row, x in zip(A, right, strict=True)]
    divisor = 1
    for k in range(len(rows)):
        pivot = rows[k]
        rows = [row if row is pivot else eliminated(row, pivot, k, divisor) for row in rows]
        divisor = pivot[k]
    return [row[-1] for row in rows], divisor * unit


def dot(a: Iterable[Any], b: Iterable[Any]) -> Any:
    """Return a . b."""
    return sum(map(mul, a, b))


def least_norm(W: Rows, wrench: list[int], low: Vector, high: Vector) -> Vector | None:
    """Return the admissible tensions of least 2-norm; arguments and result as in `nearest`."""
    return nearest(W, wrench, low, high, [Fraction(0)] * len(low))


def least_sum(W: Rows, wrench: list[int], low: Vector, high: Vector) -> Vector | None:
    """Return admissible tensions of least sum; arguments and result as in `nearest`.

    Each step goes down the gradient of the sum and back to the nearest admissible point. The steps end at an optimum
    after finitely many (proximal point algorithm; Ferris 1991). Only an optimum does not change in a step.
    """
    step = LONG_STEP * max(Fraction(1), *map(abs, low), *map(abs, high))
    before: Vector | None = None
    t: Vector | None = [Fraction(0)] * len(low)
    while t is not None and t != before:
        before, t = t, nearest(W, wrench, low, high, [x - step for x in t])
    return t


def nearest(W: Rows, wrench: list[int], low: Vector, high: Vector, target: Vector) -> Vector | None:
    """Return the t that minimises |t - target|^2 subject to W t = wrench, low <= t <= high; None if there is none.

    W (n, m) must have full row rank. The method is a dual active set (Goldfarb and Idnani 1983). The distance grows
    with each limit that becomes active, so no active set repeats. In exact arithmetic the method ends after finitely
    many steps, at the optimum or at a limit that contradicts the active limits.
    """
    t = list(target)
    free = list(range(len(t)))
    held: dict[int, list[Fraction]] = {}  # cable -> side (+1 lower limit, -1 upper limit), multiplier >= 0

    def correction(right: Sequence[Fraction | int]) -> Vector:
        """Return c (m,) = W^T y with W_free W_free^T y = right: the least free change that adds `right`."""
        part = [[row[i] for i in free] for row in W]
        y, unit = solution([[dot(a, b) for b in part] for a in part], right)
        return [Fraction(dot(y, [row[i] for row in W]), unit) for i in range(len(t))]

    missing = [w - dot(row, t) for row, w in zip(W, wrench, strict=True)]
    t = [a + b for a, b in zip(t, correction(missing), strict=True)]
    while True:
        violation, p = max((max(low[i] - t[i], t[i] - high[i]), -i) for i in range(len(t)))
        p = -p
        if violation <= 0:
            return t
        side = Fraction(1 if t[p] < low[p] else -1)
        limit = low[p] if side > 0 else high[p]
        multiplier = Fraction(0)
        while t[p] != limit:
            # Direction towards the limit that keeps W t and the active cables: side (e_p - back) over the free cables.
            back = correction([row[p] for row in W])
            slope = 1 - back[p]
            growth = {i: -sign * side * back[i] for i, (sign, _) in held.items()}
            steps = [(held[i][1] / rate, i) for i, rate in growth.items() if rate > 0]
            if slope:
                steps.append((side * (limit - t[p]) / slope, -1))  # up to the limit; preferred to an equal step
            if not steps:
                return None
            step, first = min(steps)
            if slope:
                for i in free:
                    t[i] += step * side * ((i == p) - back[i])
            for i, rate in growth.items():
                held[i][1] -= step * rate
            multiplier += step
            if first >= 0:
                del held[first]
                free = sorted([*free, first])
        held[p] = [side, multiplier]
        free.remove(p)
