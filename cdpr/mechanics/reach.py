"""Limits of cable lengths and winding speeds: how often, how far and where a motion leaves them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cdpr.model.jit import kernel
from cdpr.model.robot import Array, Robot

# A value that is told in decimals meets its limit to this share: exactly reached is not exceeded.
REACH_TOLERANCE = 1e-9

DIGITS = 9  # that a value needs at most to be told from its limit: REACH_TOLERANCE

# What a cable is that leaves a limit, in a word for figures and in a sentence, and the unit.
EXCEEDED = (
    ("shorter", "cables shorter", "m"),
    ("longer", "cables longer", "m"),
    ("faster", "cables wound faster", "m/s"),
)

Bounds = tuple[tuple[float | None, ...], ...]  # shortest, longest, fastest of each cable; () where there are none


@dataclass(frozen=True)
class Exceeded:
    """One kind of limit that was left."""

    name: str
    words: str
    cables: tuple[int, ...]  # which left it, the worst first
    first: int  # number of the first sample at which one did
    samples: int  # at which one or more did
    worst: float  # of the first of the cables
    limit: float
    unit: str

    def text(self, names: Sequence[str]) -> str:
        """One sentence; `names` are those of all cables."""
        more = f", and {len(self.cables) - 1} more" if len(self.cables) > 1 else ""
        count = f"{self.samples} sample{'s' * (self.samples > 1)}"
        which, digits = names[self.cables[0]], 4
        while digits < DIGITS and float(f"{self.worst:.{digits}g}") == self.limit:
            digits += 1
        value = f"{'down' if self.worst < self.limit else 'up'} to {self.worst:.{digits}g}"
        return f"{self.words} than allowed: {which} {value} of {self.limit:g} {self.unit}{more} ({count})"


def bounds_of(robot: Robot) -> Bounds:
    """Return the limits of a robot's cables."""
    rows = tuple(
        tuple(getattr(cable, name) for cable in robot.cables) for name in ("length_min", "length_max", "speed_max")
    )
    return rows if any(value is not None for row in rows for value in row) else ()


class Reach:
    """Counts where the cables (m) leave their limits, in pieces of any size.

    A cable that is `broken`, from a time (s) on, has none to leave any more.

    Attributes:
        limits: (3, m) shortest and longest length, m, and highest speed, m/s; infinite where there is none.
    """

    def __init__(self, bounds: Bounds, m: int, broken: Sequence[tuple[int, float]] = ()) -> None:
        free = (-math.inf, math.inf, math.inf)
        given = bounds or ((None,) * m,) * 3
        self.limits = np.array([[f if b is None else b for b in row] for row, f in zip(given, free, strict=True)])
        self._until = np.full(m, math.inf)
        self.lose(broken)
        self.counted = 0
        self.any = bool(np.isfinite(self.limits).any())
        self._worst = np.zeros((3, m))  # by how much, as a share of the limit (of 1 m where that is 0)
        self._value = np.zeros((3, m))
        self._samples = np.zeros((2, 3))  # how many, and the number of the first

    def lose(self, broken: Sequence[tuple[int, float]]) -> None:
        """Take these cables for broken, each from a time (s) on, and no others."""
        self._until[:] = math.inf
        for cable, since in broken:
            self._until[cable] = since

    def add(self, time: Array, length: Array, rate: Array) -> bool:
        """Count the samples that follow; True where one leaves a limit.

        Times (n,), s; lengths, m, and rates, m/s, both (n, m).
        """
        left = False
        if self.any:
            found = self._worst, self._value, self._samples
            left = look(self.limits, self._until, time, length, rate, self.counted, *found)
        self.counted += len(length)
        return left

    def told(self) -> Iterator[Exceeded]:
        """Yield the limits that were left."""
        for i, (name, words, unit) in enumerate(EXCEEDED):
            if samples := int(self._samples[0, i]):
                order = np.argsort(-self._worst[i], kind="stable")
                cables = tuple(int(j) for j in order if self._worst[i, j] > 0.0)
                first, worst, limit = int(self._samples[1, i]), self._value[i, cables[0]], self.limits[i, cables[0]]
                yield Exceeded(name, words, cables, first, samples, float(worst), float(limit), unit)


@kernel
def look(
    limits: Array,
    until: Array,
    time: Array,
    length: Array,
    rate: Array,
    counted: int,
    worst: Array,
    value: Array,
    samples: Array,
) -> bool:
    """Look at times (n,), lengths and rates (n, m) after `counted` samples; arrays as `Reach` has them."""
    left = False
    for k in range(length.shape[0]):
        for i in range(3):
            here = False
            for j in range(length.shape[1]):
                if time[k] >= until[j]:
                    continue
                limit = limits[i, j]
                x = abs(rate[k, j]) if i == 2 else length[k, j]
                beyond = limit - x if i == 0 else x - limit
                size = abs(limit) if limit != 0.0 else 1.0
                if beyond > REACH_TOLERANCE * size:
                    here = True
                    if beyond / size > worst[i, j]:
                        worst[i, j] = beyond / size
                        value[i, j] = x
            if here:
                left = True
                if samples[0, i] == 0.0:
                    samples[1, i] = counted + k
                samples[0, i] += 1.0
    return left
