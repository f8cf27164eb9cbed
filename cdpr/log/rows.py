"""Rows that stay in their log: read when they are asked for, a block at a time."""

from __future__ import annotations

import os
import weakref
import zlib
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from cdpr.errors import LogError
from cdpr.log.chunk import CHUNK_HEAD
from cdpr.log.mcap_file import LogFormat, Written
from cdpr.model.robot import Array

# Tables up to this size are kept in memory, B: 55 s of eight cables at 1 kHz. Larger ones of logged runs stay on disk.
IN_MEMORY = 2**25


class LogRows:
    """The table (K, width) of a logged run, as long as somebody asks for it on disk.

    Slices, numbers and lists of rows give arrays, `rows[:, columns]` reads no more than these columns into memory;
    `rows[:]` is the whole. Raises LogError where the log was changed since it was written or loaded.

    Args:
        file: descriptor of the open log; it is closed with the object, and outlives the log's name.
        form: format of the log.
        blocks: where the chunks with the rows stand.
    """

    ndim = 2

    def __init__(self, file: int, form: LogFormat, blocks: Sequence[Written]) -> None:
        self._file, self._form = file, form
        weakref.finalize(self, os.close, file)
        self._template = form.templates[0]
        self._starts = np.array([block.start for block in blocks], dtype=np.int64)
        self._numbers = np.array([block.first for block in blocks], dtype=np.int64)
        self._stops = np.cumsum([block.n for block in blocks], dtype=np.int64)
        self._last: tuple[int, Array] | None = None  # the block that was read last
        self.shape = (int(self._stops[-1]) if len(blocks) else 0, self._template.group.width)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, key: Any) -> Array:
        rows, columns = key if isinstance(key, tuple) else (key, slice(None))
        if isinstance(rows, slice) and rows.step in (None, 1):
            first, stop, _ = rows.indices(len(self))
            return self._range(first, max(first, stop), columns)
        picked = np.arange(len(self))[rows]  # numpy's own rules and errors
        parts = [self._range(int(k), int(k) + 1, columns) for k in np.atleast_1d(picked)]
        table = np.concatenate([self._range(0, 0, columns), *parts])
        return table if np.ndim(picked) else np.asarray(table[0])

    def __iter__(self) -> Iterator[Array]:
        return (self[k] for k in range(len(self)))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return self[:] if dtype is None else self[:].astype(dtype)

    def __reduce__(self) -> Any:
        return np.asarray, (self[:],)

    def _range(self, first: int, stop: int, columns: Any) -> Array:
        """Rows `first` to `stop`, excluded."""
        table = np.empty((stop - first, np.empty((0, self.shape[1]))[:, columns].shape[1]))
        k = first
        while k < stop:
            i = int(np.searchsorted(self._stops, k, side="right"))
            begin = self._begin(i)
            end = min(stop, int(self._stops[i]))
            table[k - first : end - first] = self._block(i)[k - begin : end - begin, columns]
            k = end
        return table

    def _begin(self, i: int) -> int:
        """First row of a block."""
        return int(self._stops[i - 1]) if i else 0

    def _block(self, i: int) -> Array:
        if self._last is None or self._last[0] != i:
            begin, stop = self._begin(i), int(self._stops[i])
            length = self._template.chunk_length(stop - begin)
            data = os.pread(self._file, length, int(self._starts[i]))
            records = memoryview(data)[CHUNK_HEAD.size :]
            if len(data) < length or zlib.crc32(records) != CHUNK_HEAD.unpack_from(data)[5]:
                raise LogError(
                    f"the log of this run has changed: its rows {begin} to {stop - 1} cannot be read any more"
                )
            self._last = i, self._form.rows(records, int(self._numbers[i]))
        return self._last[1]
