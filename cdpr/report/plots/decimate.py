"""Fewer points and fewer intervals, without losing a peak."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array

BINS = 600  # across the width of a figure; each gives two points


class Extrema:
    """The samples of c columns worth drawing: smallest and largest of each bin, and the first and last of all.

    Of K samples, which come in pieces of whole bins; the last piece may be shorter. Where they are few, all are taken.

    Attributes:
        last: which samples of the last piece were taken.
    """

    def __init__(self, samples: int, bins: int = BINS) -> None:
        self._all = samples <= 2 * bins
        self._size = max(1, -(-samples // bins))
        self._left = samples
        self._pieces: list[tuple[Array, Array]] = []
        self.last: NDArray[np.int64] = np.empty((0, 0), np.int64)

    def add(self, time: Array, values: Array) -> None:
        """Take the samples that follow: times (n,), s, and values (n, c)."""
        values = np.where(np.isfinite(values), values, np.nan)
        rows, columns = values.shape
        if self._all:
            index = np.repeat(np.arange(rows)[:, None], columns, axis=1)
        else:
            index = self._extreme(values)
            ends = np.zeros((1, columns), np.int64)
            first = [ends] if not self._pieces else []
            index = np.concatenate([*first, index, *([ends + rows - 1] if rows == self._left else [])])
        self._left -= rows
        self._pieces.append((time[index], np.take_along_axis(values, index, axis=0)))
        self.last = index

    def result(self) -> tuple[Array, Array]:
        """Return times and values, both (P, c) with P <= K or P <= 2 bins + 2.

        Every point is a sample at its own time. What is not finite becomes NaN; a bin without a finite sample gives
        NaN, a gap in the line.
        """
        times, values = zip(*self._pieces, strict=True)
        return np.concatenate(times), np.concatenate(values)

    def _extreme(self, values: Array) -> NDArray[np.int64]:
        rows, columns = values.shape
        size = self._size
        count = -(-rows // size)
        padding = np.full((count * size - rows, columns), np.nan)
        blocks = np.concatenate([values, padding]).reshape(count, size, columns)
        missing = np.isnan(blocks)
        low = np.where(missing, np.inf, blocks).argmin(axis=1)
        high = np.where(missing, -np.inf, blocks).argmax(axis=1)
        pairs = np.stack([np.minimum(low, high), np.maximum(low, high)], axis=1)
        inner: NDArray[np.int64] = (pairs + size * np.arange(count)[:, None, None]).reshape(-1, columns)
        return inner


def extrema(time: Array, values: Array, bins: int = BINS) -> tuple[Array, Array]:
    """Return `Extrema` of all samples at once: times (K,), values (K, c), bins of equal sample count."""
    found = Extrema(len(time), bins)
    found.add(time, values)
    return found.result()


def intervals(flags: NDArray[np.bool_], bins: int = BINS) -> list[tuple[int, int]]:
    """Return where `flags` (K,) holds, as half-open index ranges.

    A range is at least two bins wide, so that a single sample shows; ranges less than that apart are joined.
    """
    size = -(-2 * len(flags) // bins)
    edges = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    start, stop = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    if len(start) == 0:
        return []
    apart = start[1:] - stop[:-1] >= size
    start, stop = start[np.append(True, apart)], stop[np.append(apart, True)]
    return list(zip(start.tolist(), np.maximum(stop, start + size).tolist(), strict=True))
