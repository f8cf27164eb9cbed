"""Problems made to mislead tension solvers, with the truth by rational arithmetic."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from cdpr.model.robot import Array
from cdpr_solvers.exact import fractions, independent, least_norm, whole

# Share of the largest limit within which round-off may decide: the limits wider by it, nothing is feasible any more; or
# narrower by it, something still is.
BAND = Fraction(1, 10**9)


@dataclass(frozen=True)
class Case:
    """W t = wrench, low <= t <= high; moments come after three forces and are divided by `length`."""

    W: Array
    wrench: Array
    low: Array
    high: Array
    length: float = 1.0

    @property
    def rows(self) -> list[int]:
        """Directions of the rows among the six."""
        n = len(self.wrench)
        return [0, 1, 5] if self.length != 1.0 and n == 3 else list(range(n))

    def truth(self) -> str:
        """`feasible`, `infeasible`, or so close to the edge that it is `barely` the one or `nearly` the other."""
        low, high = fractions(self.low), fractions(self.high)
        band = BAND * max(1, *map(abs, low), *map(abs, high))
        if self._answer(low, high) is None:
            wider = self._answer([x - band for x in low], [x + band for x in high])
            return "infeasible" if wider is None else "nearly"
        locked = [a == b for a, b in zip(low, high, strict=True)]
        low = [x if held else x + band for x, held in zip(low, locked, strict=True)]
        high = [x if held else x - band for x, held in zip(high, locked, strict=True)]
        narrow = any(a > b for a, b in zip(low, high, strict=True))
        return "barely" if narrow or self._answer(low, high) is None else "feasible"

    def least(self) -> Array:
        """The admissible tensions of least 2-norm."""
        answer = self._answer(fractions(self.low), fractions(self.high))
        assert answer is not None
        return np.array([float(x) for x in answer])

    def equations(self) -> list[list[int]] | None:
        """Rows [W_j, wrench_j] in whole numbers, none following from others; None where they contradict."""
        return independent([whole([*row, w]) for row, w in zip(self.W, self.wrench, strict=True)])

    def _answer(self, low: list[Fraction], high: list[Fraction]) -> list[Fraction] | None:
        equations = self.equations()
        if equations is None:
            return None
        return least_norm([row[:-1] for row in equations], [row[-1] for row in equations], low, high)


def cases(seed: int, count: int) -> Iterator[Case]:
    """Parallel and equal cables, cables at a limit and locked, slivers, dependent rows, arms of 100 m, all scales."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        n, m = int(rng.integers(1, 7)), int(rng.integers(1, 13))
        if rng.random() < 0.7:
            m = int(rng.integers(n, min(n + 4, 12) + 1))
        W, length = _matrix(rng, n, m)
        low = rng.integers(0, 40, m) + rng.choice([0, 500])
        high = low + rng.integers(1, rng.choice([60, 8000]), m)
        wrench, low, high = _within(rng, W, [*map(Fraction, low.tolist())], [*map(Fraction, high.tolist())])
        unit = Fraction(2) ** int(rng.integers(-10, 21))
        exact = [unit * x for x in wrench]
        wrench, low, high = (np.array([float(unit * x) for x in values]) for values in (wrench, low, high))
        problem = Case(np.ascontiguousarray(W, dtype=float), wrench, low, high, length)
        # Rows that depend on each other contradict each other by chance once their wrench is rounded: not tested.
        if fractions(wrench) == exact or problem.equations() is not None:
            yield problem


def _matrix(rng: np.random.Generator, n: int, m: int) -> tuple[Array, float]:
    """A matrix of small whole numbers, so that products with tensions are not rounded, and the length of its arms."""
    length = 1.0
    if n in (3, 6) and rng.random() < 0.5:
        u, b = rng.integers(-5, 6, (m, 3)), rng.integers(-100, 101, (m, 3))
        if n == 3:
            u[:, 2] = b[:, 2] = 0
        W = np.hstack([u, np.cross(b, u)]).T[[0, 1, 5] if n == 3 else slice(None)]
        length = float(np.sqrt((b**2).sum(1).mean()))
    else:
        W = rng.integers(-4, 5, (n, m))
    if rng.random() < 0.25:
        W[rng.integers(n)] = W[rng.integers(n)] * rng.integers(-2, 3)
    if rng.random() < 0.5:
        for _ in range(rng.integers(1, 4)):
            W[:, rng.integers(m)] = W[:, rng.integers(m)] * rng.choice([1, 1, -1, 2, 3, -2])
    return W, length


def _within(
    rng: np.random.Generator, W: Array, low: list[Fraction], high: list[Fraction]
) -> tuple[list[Fraction], list[Fraction], list[Fraction]]:
    """Choose tensions, move limits to them if the case requires that, and return their wrench and the limits."""
    n, m = W.shape
    width = Fraction(1, 2 ** int(rng.integers(20, 41))) * 1024  # 1e-6 to 1e-12 of a kilonewton
    t = [a + (b - a) * Fraction(int(rng.integers(0, 9)), 8) for a, b in zip(low, high, strict=True)]
    kind = rng.choice(["between", "at_limits", "sliver", "random", "edge", "inside", "outside"])
    push = rng.integers(-3, 4, n) @ W  # at the edge of what the cables can do in this direction, all are at a limit
    for i in range(m):
        if kind == "at_limits" and rng.random() < 0.5:
            t[i] = low[i] if rng.random() < 0.5 else high[i]
        elif kind == "sliver" and rng.random() < 0.7:
            low[i], high[i] = t[i] - width * int(rng.integers(0, 4)), t[i] + width * int(rng.integers(0, 4))
        elif kind in ("edge", "inside", "outside") and push[i]:
            t[i] = high[i] if push[i] > 0 else low[i]
            if kind != "edge" and rng.random() < 0.6:
                beyond = 1 if kind == "outside" else -1
                t[i] += beyond * int(np.sign(push[i])) * min(width, high[i] - low[i])
    for i in range(m):
        if rng.random() < 0.05:
            low[i] = high[i] = t[i]
    wrench = [sum((int(a) * b for a, b in zip(row, t, strict=True)), Fraction(0)) for row in W]
    if kind == "random":
        wrench = [w + int(rng.integers(-200, 201)) for w in wrench]
    return wrench, low, high
