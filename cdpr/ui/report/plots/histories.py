"""Decimated time histories of a run.

The rows of a long run are on disk. They are read once, block by block, for all figures.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from operator import attrgetter, itemgetter
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from cdpr.log.run import Run
from cdpr.log.summary import PIECE
from cdpr.model.robot import Array
from cdpr.ui.report.plots.decimate import BINS, Extrema


class Points(NamedTuple):
    """Columns of a quantity, each reduced to the samples to plot."""

    time: Array  # (P, c), s
    values: Array  # (P, c)

    def columns(self, chosen: slice | list[int]) -> Points:
        """Return some of the columns."""
        return Points(self.time[:, chosen], self.values[:, chosen])


def points(time: Array, values: Array) -> Points:
    """Return the samples to plot of values (K, c) at times (K,), s."""
    bins = Extrema(len(time))
    bins.add(time, values)
    return Points(*bins.result())


class Histories:
    """Time histories of the K rows of a run, for figures and tables.

    Attributes:
        status: (K,), verified solver status of each row.
        outline: the run, or for a long run the rows that are sufficient to draw the platform's path.
    """

    def __init__(self, run: Run) -> None:
        self._run = run
        self._points: dict[str, Points] = {}
        self.status: NDArray[np.int8] = np.empty(0, np.int8)
        self.outline = run
        if isinstance(run.rows, np.ndarray):
            self.status = _status(run)
        else:
            own = [PLUGIN + column.name for column in run.header.columns]
            absent = () if run.header.layout.has("electrical") else _ELECTRICAL
            shown = (name for name in QUANTITIES if name not in (*RARE, *absent) and self._stands_for(name) == name)
            self._gather([*shown, *own])

    def __getitem__(self, name: str) -> Points:
        name = self._stands_for(name)
        if name not in self._points:
            self._gather(RARE if name in RARE else (name,))
        return self._points[name]

    def _stands_for(self, name: str) -> str:
        """Return the name of the stored quantity: tensions of ideal cables equal the commands."""
        return "tension" if name == "cable_tension" and self._run.header.ideal_cables else name

    def _gather(self, names: Sequence[str]) -> None:
        """Read the run once and decimate these quantities."""
        bins, attitude = Extrema(len(self._run.rows)), Attitude()
        status, outline = [self.status], []
        places: dict[str, slice] = {}  # columns of each quantity: all are decimated together
        room = np.empty(0)
        for part, n in self._parts():
            with np.errstate(all="ignore"):  # a diverged run ends in inf and NaN
                found = {name: attitude.follow(part) if name == "attitude" else _quantity(name)(part) for name in names}
            tables = [values[:, None] if values.ndim == 1 else values for values in found.values()]
            stops = np.cumsum([0, *(values.shape[1] for values in tables)]).tolist()
            places = {name: slice(*ends) for name, ends in zip(found, pairwise(stops), strict=True)}
            room = room if room.size >= n * stops[-1] else np.empty(n * stops[-1])  # allocation costs as much
            columns = room[: n * stops[-1]].reshape(stops[-1], n)
            for values, place in zip(tables, places.values(), strict=True):
                columns[place] = values[:n].T
            bins.add(part.time[:n], columns.T)
            if self.outline is self._run and not isinstance(self._run.rows, np.ndarray):
                status.append(_status(part)[:n])
                chosen = np.unique(np.concatenate([bins.last[:, places[name]] for name in PLACES], axis=None))
                outline.append(part.rows[chosen])
        drawn = Points(*bins.result())
        self._points |= {name: drawn.columns(place) for name, place in places.items()}
        if outline:
            self.status = np.concatenate(status)
            self.outline = replace(self._run, rows=np.concatenate(outline))

    def _parts(self) -> Iterator[tuple[Run, int]]:
        """Yield parts of n rows (whole bins), each with the following row, which some quantities need; and n."""
        run, count = self._run, len(self._run.rows)
        size = count
        if not isinstance(self._run.rows, np.ndarray):
            bins = -(-count // BINS) or 1
            size = bins * -(-PIECE // bins)
            run = replace(run, start=run.part(0, 0).start)  # read once
        for first in range(0, max(count, 1), size or 1):
            yield run.part(first, first + size + 1), min(size, count - first)


def _status(run: Run) -> NDArray[np.int8]:
    status: NDArray[np.int8] = np.nan_to_num(run.solver_status, nan=-1.0).astype(np.int8)
    return status


class Attitude:
    """Roll, pitch and yaw of the desired and the actual attitude, unwrapped across successive parts of a run."""

    def __init__(self) -> None:
        self._last: Array | None = None

    def follow(self, run: Run) -> Array:
        """Return desired and actual angles (K, 6), degrees; the first row must be the last row of the previous call."""
        desired, actual = roll_pitch_yaw(run)
        if self._last is not None:
            turns = 2.0 * np.pi * np.rint((self._last - desired[0]) / (2.0 * np.pi))
            desired, actual = desired + turns, actual + turns
        self._last = desired[-1] if len(desired) else None
        return np.asarray(np.degrees(np.concatenate([desired, actual], axis=1)))


def roll_pitch_yaw(run: Run) -> Array:
    """Return roll, pitch, yaw, desired and actual, (2, K, 3), rad, unwrapped."""
    desired = np.unwrap(_rpy(run.desired_orientation), axis=0)
    apart = _rpy(run.orientation) - desired
    return np.stack([desired, desired + (apart + np.pi) % (2.0 * np.pi) - np.pi])


def _rpy(q: Array) -> Array:
    """Return roll, pitch, yaw (K, 3) of unit quaternions (K, 4); R = Rz(yaw) Ry(pitch) Rx(roll)."""
    w, x, y, z = np.ascontiguousarray(q.T)
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.stack([roll, pitch, yaw], axis=1)


def _norm_and_parts(vectors: Array) -> Array:
    return np.concatenate([np.linalg.norm(vectors, axis=1, keepdims=True), vectors], axis=1)


PLACES = ("position", "desired_position")
_PLAIN = (
    *PLACES,
    *("velocity", "desired_velocity", "angular_velocity", "desired_angular_velocity"),
    *("acceleration", "desired_acceleration", "angular_acceleration", "desired_angular_acceleration"),
    *("tension", "cable_tension", "length", "rate", "margin", "residual", "external", "energy_residual"),
)
_ELECTRICAL = ("motor_current", "electrical_power")  # if the run has them
QUANTITIES: dict[str, Callable[[Run], Array]] = {
    **{name: attrgetter(name) for name in (*_PLAIN, *_ELECTRICAL)},
    "attitude": lambda run: Attitude().follow(run),  # degrees; desired, then actual
    "position_error": lambda run: _norm_and_parts(1e3 * run.position_error),  # mm; the norm first
    "orientation_error": lambda run: _norm_and_parts(1e3 * run.orientation_error),  # mrad
    "friction": lambda run: run.tension - run.cable_tension,
    "highest": lambda run: run.cable_tension.max(axis=1),
    "lowest": lambda run: run.cable_tension.min(axis=1),
    "energies": lambda run: np.stack(
        [run.kinetic, run.potential_change, run.cable_work, run.external_work]
        + [run[column] for column in run.header.further_works.values()],
        axis=1,
    ),
    "powers": lambda run: np.stack([run.cable_power, run.external_power], axis=1),
}

# Quantities that the report of a run does not show; they are computed on first use.
RARE = ("highest", "lowest", "friction")

PLUGIN = "column "  # prefix of plugin columns, whose names may equal those above


def _quantity(name: str) -> Callable[[Run], Array]:
    return itemgetter(name.removeprefix(PLUGIN)) if name.startswith(PLUGIN) else QUANTITIES[name]


_KNOWN: WeakKeyDictionary[Run, Histories] = WeakKeyDictionary()


def histories(run: Run) -> Histories:
    """Return the cached histories of a run."""
    if run not in _KNOWN:
        _KNOWN[run] = Histories(replace(run))  # a copy, so that the cache does not keep the key alive
    return _KNOWN[run]
