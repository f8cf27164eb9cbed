"""Limits of what cables do, such as their lengths and winding speeds: how often, how far and where they are left."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from cdpr.model.robot import Array, Robot
from cdpr.native.bind import bind

# A value that is told in decimals meets its limit to this share: exactly reached is not exceeded.
REACH_TOLERANCE = 1e-9

DIGITS = 9  # that a value needs at most to be told from its limit: REACH_TOLERANCE


@dataclass(frozen=True)
class Kind:
    """A kind of limit, one of each cable.

    Attributes:
        name, words: what a cable is that leaves it, in a word for figures and in a sentence.
        unit: of the limit.
        column: what is limited.
        upper: whether it is a highest value.
        magnitude: whether the sign of the value says nothing.
        room: column that says how far inside its limits the cable is, where that is not plain from the value.
    """

    name: str
    words: str
    unit: str
    column: str
    upper: bool
    magnitude: bool = False
    room: str = ""


LENGTHS = (
    Kind("shorter", "cables shorter", "m", "length", upper=False),
    Kind("longer", "cables longer", "m", "length", upper=True),
    Kind("faster", "cables wound faster", "m/s", "rate", upper=True, magnitude=True),
)

Bounds = tuple[tuple[float | None, ...], ...]  # shortest, longest, fastest of each cable; () where there are none
Changes = Sequence[tuple[float, Mapping[str, Array]]]  # from a time (s) on, the limits (m,) of kinds by name


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


def plain_columns(m: int) -> dict[str, slice]:
    """Return the columns of rows of time, lengths and rates of m cables, side by side."""
    return {"time": slice(0, 1), "length": slice(1, 1 + m), "rate": slice(1 + m, 1 + 2 * m)}


class Reach:
    """Counts where the cables (m) leave their limits, in pieces of any size.

    A cable that is `broken`, from a time (s) on, has none to leave any more.

    Args:
        columns: where in the rows the time stands and what is limited.
        bounds: shortest and longest lengths, m, and highest speeds, m/s.
        m: number of cables.
        broken: which cables, counted from 0, and since when.
        more: further kinds, the limit of each cable (m,), and by how much one may be left unnoticed.
        changes: times (s) from which limits of kinds in `more` are others, (m,) by the kind's name.

    Attributes:
        kinds: of the limits that there are.
        limits: (c, k, m) of these kinds, one table for each time from which they hold; infinite where there is none.
    """

    def __init__(
        self,
        columns: Mapping[str, slice],
        bounds: Bounds,
        m: int,
        broken: Sequence[tuple[int, float]] = (),
        more: Sequence[tuple[Kind, Array, float]] = (),
        changes: Changes = (),
    ) -> None:
        given = [
            np.array([(math.inf if kind.upper else -math.inf) if bound is None else bound for bound in row])
            for kind, row in zip(LENGTHS, bounds, strict=False)
        ]
        # What has a limit of its own kind is told as a share of it (of 1 m where that is 0), the others as they are.
        sizes = [np.where(row != 0.0, np.abs(row), 1.0) for row in given] + [np.ones(m)] * len(more)
        tolerances = [REACH_TOLERANCE * size for size in sizes[: len(given)]]
        tolerances += [np.full(m, tolerance) for _, _, tolerance in more]
        self.kinds = (*LENGTHS[: len(given)], *(kind for kind, _, _ in more))
        self._first = np.array([*given, *(limit for _, limit, _ in more)]).reshape(-1, m)
        places = [
            [columns[kind.column].start, kind.upper, kind.magnitude, columns[kind.room].start if kind.room else -1]
            for kind in self.kinds
        ]
        count = len(self.kinds)
        self._time = np.array([columns["time"].start], dtype=np.int64)
        self._kinds = np.array(places, dtype=np.int64).reshape(-1, 4)
        self._tolerances, self._sizes = np.array(tolerances).reshape(-1, m), np.array(sizes).reshape(-1, m)
        self._until = np.full(m, math.inf)
        self.lose(broken, changes)
        # By how much at the worst, the value and the limit there; how many samples, and the number of the first.
        self._found: tuple[Array, ...] = (*(np.zeros((count, m)) for _ in range(3)), np.zeros((2, count)))
        self.counted = 0

    @property
    def any(self) -> bool:
        """Whether there are limits that can be left."""
        return bool(self.kinds)

    def lose(self, broken: Sequence[tuple[int, float]], changes: Changes = ()) -> None:
        """Replace the broken cables, each with the time (s) from which it is, and the changes of limits."""
        self._until[:] = math.inf
        for cable, since in broken:
            self._until[cable] = since
        tables = [self._first]
        for _, limits in changes:
            rows = [limits.get(kind.name, row) for kind, row in zip(self.kinds, tables[-1], strict=True)]
            tables.append(np.array(rows).reshape(tables[-1].shape))
        self.limits, self._since = np.array(tables), np.array([-math.inf, *(time for time, _ in changes)])

    def leaving(self, row: Array) -> Callable[[], int]:
        """Return an operation that tells whether a live sample (width,) leaves a limit: 1, else 0."""
        return bind("beyond_limits", **self._about(), row=row)

    def add(self, rows: Array) -> bool:
        """Count the samples that follow, (n, width); True where one leaves a limit."""
        left = self.any and self._count(np.ascontiguousarray(rows))
        self.counted += len(rows)
        return left

    def _count(self, rows: Array) -> bool:
        far, value, limit, samples = self._found
        look = bind(
            "limit_violations",
            **self._about(),
            sizes=self._sizes,
            rows=rows,
            worst=far,
            worst_value=value,
            worst_limit=limit,
            samples=samples,
            counted=self.counted,
        )
        found = look()
        if found < 0:
            raise ValueError(f"rows: expected the columns of all limits, got {rows.shape[1]}")
        return found == 1

    def _about(self) -> dict[str, Array]:
        """The limits as operations take them (reach.hpp)."""
        return {
            "time": self._time,
            "kinds": self._kinds,
            "since": self._since,
            "limits": self.limits,
            "tolerances": self._tolerances,
            "until": self._until,
        }

    def copy(self) -> Reach:
        """Return one that has counted as much, and counts on by itself; cables break for both."""
        other = copy(self)
        other._found = tuple(array.copy() for array in self._found)
        return other

    def told(self) -> list[Exceeded]:
        """Return the limits that were left."""
        told = []
        far, value, limits, samples = self._found
        for i, kind in enumerate(self.kinds):
            if count := int(samples[0, i]):
                order = np.argsort(-far[i], kind="stable")
                cables = tuple(int(j) for j in order if far[i, j] > 0.0)
                first, worst, limit = int(samples[1, i]), value[i, cables[0]], limits[i, cables[0]]
                words, unit = kind.words, kind.unit
                told.append(Exceeded(kind.name, words, cables, first, count, float(worst), float(limit), unit))
        return told

    def counts(self) -> dict[str, int]:
        """Return at how many samples each kind of limit that there is was left."""
        return {kind.name: int(count) for kind, count in zip(self.kinds, self._found[-1][0], strict=True)}
