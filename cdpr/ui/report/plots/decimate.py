"""Decimation of samples and intervals that preserves peaks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array

BINS = 600  # across the width of a figure; each gives two points
LARGEST = 1e100  # axes overflow beyond: such values are treated as non-finite


class Extrema:
    """Selection of the samples to plot: minimum and maximum of each bin, and the first and last sample.

    The K samples of c columns are added in blocks of whole bins; only the last block may be shorter. Short series are
    kept completely.

    Attributes:
        last: (p, c), indices of the selected samples of the last block.
    """

    def __init__(self, samples: int, bins: int = BINS) -> None:
        self._all = samples <= 2 * bins
        self._size = max(1, -(-samples // bins))
        self._left = samples
        self._pieces: list[tuple[Array, Array]] = []
        self.last: NDArray[np.int64] = np.empty((0, 0), np.int64)

    def add(self, time: Array, values: Array) -> None:
        """Add the next samples: times (n,), s, and values (n, c)."""
        rows, columns = values.shape
        if self._all:
            index = np.repeat(np.arange(rows)[:, None], columns, axis=1)
        else:
            index = self._extreme(values)
            ends = np.zeros((1, columns), np.int64)
            first = [ends] if not self._pieces else []
            index = np.concatenate([*first, index, *([ends + rows - 1] if rows == self._left else [])])
        self._left -= rows
        chosen = np.take_along_axis(values, index, axis=0)
        self._pieces.append((time[index], np.where(_drawable(chosen), chosen, np.nan)))
        self.last = index

    def result(self) -> tuple[Array, Array]:
        """Return times and values, both (P, c) with P <= K or P <= 2 bins + 2.

        Every point is a sample at its own time. Values that are not finite or beyond LARGEST become NaN. A bin of such
        values gives NaN, a gap in the line.
        """
        times, values = zip(*self._pieces, strict=True)
        return np.concatenate(times), np.concatenate(values)

    def _extreme(self, values: Array) -> NDArray[np.int64]:
        """Return the indices (2 bins, c) of each bin's minimum and maximum, in order of time."""
        rows, size = len(values), self._size
        whole = rows - rows % size
        parts = [(first, values[first:stop]) for first, stop in ((0, whole), (whole, rows)) if stop > first]
        found = [first + _pairs(part, min(size, len(part))) for first, part in parts]
        return np.concatenate(found)


def _drawable(values: Array) -> NDArray[np.bool_]:
    drawable: NDArray[np.bool_] = np.abs(values) < LARGEST
    return drawable


def _pairs(values: Array, size: int) -> NDArray[np.int64]:
    """Return the same for whole bins of `size` values (n, c)."""
    bins = np.ascontiguousarray(values.T).reshape(values.shape[1], -1, size)  # contiguous bins are four times faster
    low, high = bins.argmin(axis=2), bins.argmax(axis=2)
    # If a bin holds values that cannot be plotted, one of its extrema is such a value.
    ends = [_drawable(np.take_along_axis(bins, each[..., None], 2)) for each in (low, high)]
    mended = ~np.logical_and(*ends).all(axis=(1, 2))
    if mended.any():
        shown = _drawable(bins[mended])
        low[mended] = np.where(shown, bins[mended], np.inf).argmin(axis=2)
        high[mended] = np.where(shown, bins[mended], -np.inf).argmax(axis=2)
    pairs = np.stack([np.minimum(low, high), np.maximum(low, high)], axis=2)
    pairs += size * np.arange(bins.shape[1])[:, None]
    return np.ascontiguousarray(pairs.reshape(len(bins), -1).T)


def extrema(time: Array, values: Array, bins: int = BINS) -> tuple[Array, Array]:
    """Return the result of `Extrema` for times (K,) and values (K, c), in bins of equal sample count."""
    found = Extrema(len(time), bins)
    found.add(time, values)
    return found.result()


def intervals(flags: NDArray[np.bool_], bins: int = BINS) -> list[tuple[int, int]]:
    """Return the ranges in which `flags` (K,) is True, as half-open index intervals.

    A range is at least two bins wide, so that a single sample is visible. Ranges closer than that are joined.
    """
    size = -(-2 * len(flags) // bins)
    edges = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    start, stop = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    if len(start) == 0:
        return []
    apart = start[1:] - stop[:-1] >= size
    start, stop = start[np.append(True, apart)], stop[np.append(apart, True)]
    return list(zip(start.tolist(), np.maximum(stop, start + size).tolist(), strict=True))
