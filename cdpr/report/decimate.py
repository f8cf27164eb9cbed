"""Fewer points and fewer intervals, without losing a peak."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array

BINS = 600  # across the width of a figure; each gives two points


def extrema(time: Array, values: Array, bins: int = BINS) -> tuple[Array, Array]:
    """Return the samples worth drawing: smallest and largest of each bin, and the first and last of all.

    Args:
        time: (K,).
        values: (K, c).
        bins: number of bins of equal sample count.

    Returns:
        Times and values, both (P, c) with P <= K or P <= 2 bins + 2. Every point is a sample at its own time.
        What is not finite becomes NaN; a bin without a finite sample gives NaN, a gap in the line.
    """
    values = np.where(np.isfinite(values), values, np.nan)
    rows, columns = values.shape
    if rows <= 2 * bins:
        return np.broadcast_to(time[:, None], values.shape), values
    size = -(-rows // bins)
    count = -(-rows // size)
    padding = np.full((count * size - rows, columns), np.nan)
    blocks = np.concatenate([values, padding]).reshape(count, size, columns)
    missing = np.isnan(blocks)
    low = np.where(missing, np.inf, blocks).argmin(axis=1)
    high = np.where(missing, -np.inf, blocks).argmax(axis=1)
    pairs = np.stack([np.minimum(low, high), np.maximum(low, high)], axis=1)
    inner = (pairs + size * np.arange(count)[:, None, None]).reshape(-1, columns)
    ends = np.zeros((1, columns), dtype=inner.dtype)
    index = np.concatenate([ends, inner, ends + rows - 1])
    return time[index], np.take_along_axis(values, index, axis=0)


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
