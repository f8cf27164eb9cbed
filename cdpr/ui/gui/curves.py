"""Curves of a running simulation, decimated to screen resolution with their extremes preserved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.model.robot import Array

MOST = 4000  # points per curve: more than the width of a screen
PIECE = 400  # points per message: encoding interrupts the simulation for some milliseconds


@dataclass(frozen=True)
class Mark:
    """Last point that a window has received."""

    run: int
    points: int


class Curves:
    """Values over time. All methods except `add` must be called while holding the broadcast's lock.

    Samples are grouped into spans of equal length; a curve keeps the minimum and maximum of each span, in order of
    time. Curves of short runs keep every sample.
    """

    def __init__(self) -> None:
        self._run, self._shown = 0, 0
        self.begin({}, 1)

    def begin(self, names: Mapping[str, tuple[int, int]], samples: int) -> None:
        """Clear the curves; `names` holds the number of columns and of decimals of each quantity."""
        self._names, self._span = dict(names), 1 if samples <= MOST else -(-2 * samples // MOST)
        self._run += 1
        self._count, self._shown = 0, 0
        width = 1 + sum(columns for columns, _ in names.values())
        self._points = np.empty((min(samples, MOST + 2), width))
        self._rest = np.empty((0, width))

    def add(self, rows: Array) -> None:
        """Add samples (n, 1 + columns): time, s, and all values in columns."""
        if self._span == 1:
            self._append(rows)
            return
        rows = np.concatenate([self._rest, rows])
        whole = len(rows) // self._span
        self._rest = rows[whole * self._span :]
        if whole:
            self._append(_extremes(rows[: whole * self._span].reshape(whole, self._span, -1)))

    def end(self) -> None:
        """Add the remaining samples after the last one."""
        if len(self._rest):
            self._append(_extremes(self._rest[None]))
            self._rest = self._rest[:0]

    def show(self) -> None:
        """Publish all points so far."""
        self._shown = self._count

    def start(self) -> Mark:
        """Return the mark of a window without any points."""
        return Mark(-1, 0)

    def since(self, mark: Mark) -> tuple[list[dict[str, Any]], Mark]:
        """Return the next messages for a window and its new mark; more points may remain."""
        first = mark.points if mark.run == self._run else 0
        stop = min(self._shown, first + PIECE)
        if mark.run == self._run and first == stop:
            return [], mark
        message: dict[str, Any] = {"kind": "samples", "from": first, "reset": mark.run != self._run}
        message["t"] = np.round(self._points[first:stop, 0], 6).tolist()
        at = 1
        for name, (columns, decimals) in self._names.items():
            values = np.round(self._points[first:stop, at : at + columns], decimals)
            message[name] = json_values(values if name in PER_CABLE else values[:, 0])
            at += columns
        return [message], Mark(self._run, stop)

    def _append(self, points: Array) -> None:
        room = len(self._points) - self._count
        points = points[:room]
        self._points[self._count : self._count + len(points)] = points
        self._count += len(points)


PER_CABLE = ("tension", "length")


def json_values(values: Array) -> Any:
    """Return numbers as lists, with None for non-finite numbers, which JSON does not support."""
    if np.isfinite(values).all():
        return values.tolist()
    out = values.astype(object)
    out[~np.isfinite(values)] = None
    return out.tolist()


def _extremes(spans: Array) -> Array:
    """Return two points (2 b, k) for each of b spans of samples (b, n, k): the extrema, in order of time."""
    values = np.nan_to_num(spans, nan=0.0)
    low, high = values.argmin(axis=1)[:, None], values.argmax(axis=1)[:, None]
    first, second = np.minimum(low, high), np.maximum(low, high)
    pair = np.concatenate([np.take_along_axis(spans, first, 1), np.take_along_axis(spans, second, 1)], axis=1)
    pair[:, :, 0] = spans[:, [0, spans.shape[1] // 2], 0]
    return pair.reshape(-1, spans.shape[2])
