"""Violations of cable limits, such as lengths and winding speeds: number of samples, extent and time."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from cdpr.model.robot import Array, Robot
from cdpr.native.bind import bind

# Relative tolerance of a limit, for values read from decimal numbers: a value equal to its limit does not violate it.
REACH_TOLERANCE = 1e-9

DIGITS = 9  # largest number of digits that distinguishes a value from its limit, see REACH_TOLERANCE


@dataclass(frozen=True)
class Kind:
    """Kind of limit, with one value per cable.

    Attributes:
        name, words: description of a violating cable, as one word for numbers and for a sentence.
        unit: unit of the limit.
        column: limited column.
        upper: True for an upper limit.
        magnitude: True if the limit applies to the absolute value.
        room: column with the distance of the cable from its limits, if the value does not give it.
    """

    name: str
    words: str
    unit: str
    column: str
    upper: bool
    magnitude: bool = False
    room: str = ""


LENGTHS = (
    Kind("shorter", "cables shorter than allowed", "m", "length", upper=False),
    Kind("longer", "cables longer than allowed", "m", "length", upper=True),
    Kind("faster", "cables wound faster than allowed", "m/s", "rate", upper=True, magnitude=True),
)

Bounds = tuple[tuple[float | None, ...], ...]  # shortest, longest, fastest of each cable; () without limits
Changes = Sequence[tuple[float, Mapping[str, Array]]]  # times [s] and the limits (m,) of kinds by name from then on


@dataclass(frozen=True)
class Exceeded:
    """Violations of one kind of limit."""

    name: str
    words: str
    cables: tuple[int, ...]  # violating cables, the worst first
    first: int  # index of the first sample with a violation
    samples: int  # number of samples with a violation
    worst: float  # worst value of the first of the cables
    limit: float
    unit: str

    def text(self, names: Sequence[str]) -> str:
        """Return one sentence on the violations; `names` are the names of all cables."""
        more = f", and {len(self.cables) - 1} more" if len(self.cables) > 1 else ""
        count = f"{self.samples} sample{'s' * (self.samples > 1)}"
        which, digits = names[self.cables[0]], 4
        while digits < DIGITS and float(f"{self.worst:.{digits}g}") == self.limit:
            digits += 1
        value = f"{'down' if self.worst < self.limit else 'up'} to {self.worst:.{digits}g}"
        return f"{self.words}: {which} {value} of {self.limit:g} {self.unit}{more} ({count})"


def bounds_of(robot: Robot) -> Bounds:
    """Return the limits of the cables of a robot."""
    rows = tuple(
        tuple(getattr(cable, name) for cable in robot.cables) for name in ("length_min", "length_max", "speed_max")
    )
    return rows if any(value is not None for row in rows for value in row) else ()


def plain_columns(m: int) -> dict[str, slice]:
    """Return the columns of rows with time, lengths and rates of m cables side by side."""
    return {"time": slice(0, 1), "length": slice(1, 1 + m), "rate": slice(1 + m, 1 + 2 * m)}


class Reach:
    """Counter of limit violations of the cables (m) in rows of any number.

    A `broken` cable has no limits from its time of breaking [s] on.

    Args:
        columns: columns of the time and of the limited values in the rows.
        bounds: shortest and longest lengths [m], and highest speeds [m/s].
        m: number of cables.
        broken: numbers of the broken cables, from 0, and the times at which they break [s].
        more: further kinds, the limit of each cable (m,), and the tolerance of the limit.
        changes: times [s] at which limits of kinds in `more` change, with the new limits (m,) by the name of the kind.

    Attributes:
        kinds: kinds of the existing limits.
        limits: (c, k, m) limits of these kinds, one table per time of change; infinite if there is none.
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
        # Violations of own limits are relative to the limit (to 1 m for a limit of 0), those of further kinds are
        # absolute.
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
        # Extent of the worst violation, value and limit there; number of samples and index of the first one.
        self._found: tuple[Array, ...] = (*(np.zeros((count, m)) for _ in range(3)), np.zeros((2, count)))
        self.counted = 0

    @property
    def any(self) -> bool:
        """True if there are limits."""
        return bool(self.kinds)

    def lose(self, broken: Sequence[tuple[int, float]], changes: Changes = ()) -> None:
        """Replace the broken cables, each with its time of breaking [s], and the changes of limits."""
        self._until[:] = math.inf
        for cable, since in broken:
            self._until[cable] = since
        tables = [self._first]
        for _, limits in changes:
            rows = [limits.get(kind.name, row) for kind, row in zip(self.kinds, tables[-1], strict=True)]
            tables.append(np.array(rows).reshape(tables[-1].shape))
        self.limits, self._since = np.array(tables), np.array([-math.inf, *(time for time, _ in changes)])

    def leaving(self, row: Array) -> Callable[[], int]:
        """Return an operation that returns 1 if a live sample (width,) violates a limit, else 0."""
        return bind("beyond_limits", **self._about(), row=row)

    def add(self, rows: Array) -> bool:
        """Count the samples that follow, (n, width), and return True if one violates a limit."""
        left = self.any and self._count(np.ascontiguousarray(rows))
        self.counted += len(rows)
        return left

    def _count(self, rows: Array) -> bool:
        far, value, limit, samples = self._found
        count = bind(
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
        found = count()
        if found < 0:
            raise ValueError(f"rows: expected the columns of all limits, got {rows.shape[1]}")
        return found == 1

    def _about(self) -> dict[str, Array]:
        """Return the limits as arguments of the operations (reach.hpp)."""
        return {
            "time": self._time,
            "kinds": self._kinds,
            "since": self._since,
            "limits": self.limits,
            "tolerances": self._tolerances,
            "until": self._until,
        }

    def copy(self) -> Reach:
        """Return a copy with the same counts that counts independently. Both share the broken cables."""
        other = copy(self)
        other._found = tuple(array.copy() for array in self._found)
        return other

    def exceeded(self) -> list[Exceeded]:
        """Return the violations of each limit."""
        texts = []
        far, value, limits, samples = self._found
        for i, kind in enumerate(self.kinds):
            if count := int(samples[0, i]):
                order = np.argsort(-far[i], kind="stable")
                cables = tuple(int(j) for j in order if far[i, j] > 0.0)
                first, worst, limit = int(samples[1, i]), value[i, cables[0]], limits[i, cables[0]]
                words, unit = kind.words, kind.unit
                texts.append(Exceeded(kind.name, words, cables, first, count, float(worst), float(limit), unit))
        return texts

    def counts(self) -> dict[str, int]:
        """Return the number of violating samples for each existing kind of limit."""
        return {kind.name: int(count) for kind, count in zip(self.kinds, self._found[-1][0], strict=True)}
