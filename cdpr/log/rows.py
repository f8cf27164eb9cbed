"""Rows of a log on disk, read on access, a block at a time."""

from __future__ import annotations

import os
import weakref
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from cdpr.base.errors import LogError
from cdpr.base.problems import short_repr
from cdpr.log.chunk_index import Written
from cdpr.log.mcap_file import LogFormat
from cdpr.model.robot import Array

# Tables up to this size are kept in memory, B: 55 s of eight cables at 1 kHz. Larger tables of logged runs stay on
# disk.
IN_MEMORY = 2**25


class LogRows:
    """Table (K, width) of a logged run on disk.

    It is indexed like an array, without new axes: `rows[:]` is the whole table, `rows[k, 3]` a number, and `rows[:,
    columns]` reads only these columns into memory. All data is verified when read.

    Args:
        file: descriptor of the open log, closed with the object; it remains valid if the log is renamed or removed.
        form: format of the log.
        blocks: chunks with the rows.
        rest: rows in memory after these, which could not be written.
        name: name of the log for messages.

    Raises:
        LogError: on access, if the log is damaged or has changed since it was written or loaded.
        IndexError: as in numpy.
    """

    ndim = 2

    def __init__(
        self, file: int, form: LogFormat, blocks: Sequence[Written], rest: Array | None = None, *, name: str
    ) -> None:
        self._file, self._form, self._name = file, form, name
        weakref.finalize(self, os.close, file)
        self._template = form.templates[0]
        self._blocks = blocks
        self._rest = np.empty((0, self._template.group.width)) if rest is None else rest
        self._stops = np.cumsum([*(block.n for block in blocks), len(self._rest)], dtype=np.int64)
        self._last: tuple[int, Array] | None = None  # last block read
        self.shape = (int(self._stops[-1]), self._template.group.width)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, key: Any) -> Any:
        rows, columns = _split(key)
        if isinstance(rows, slice) and rows.step in (None, 1):
            first, stop, _ = rows.indices(len(self))
            return self._range(first, max(first, stop), columns)
        picked = np.arange(len(self))[rows]  # numpy's own rules and errors
        if isinstance(rows, slice) or isinstance(columns, slice):
            parts = [self._range(int(k), int(k) + 1, columns) for k in picked.flat]
            table = np.concatenate([self._range(0, 0, columns), *parts])
            return table.reshape(picked.shape + table.shape[1:])
        pairs = np.broadcast(picked, np.arange(self.shape[1])[columns])  # lists of both are paired
        return np.array([self._range(k, k + 1, j)[0] for k, j in pairs], dtype=float).reshape(pairs.shape)[()]

    def __iter__(self) -> Iterator[Array]:
        return (self[k] for k in range(len(self)))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.asarray(self[:], dtype=dtype)

    def __reduce__(self) -> Any:
        return np.asarray, (self[:],)

    def _range(self, first: int, stop: int, columns: Any) -> Array:
        """Return rows `first` to `stop` (excluded)."""
        table = np.empty((stop - first, *np.empty((0, self.shape[1]))[:, columns].shape[1:]))
        straight, k = isinstance(columns, slice) and columns == slice(None), first
        while k < stop:
            i = int(np.searchsorted(self._stops, k, side="right"))
            begin = self._begin(i)
            end = min(stop, int(self._stops[i]))
            to = table[k - first : end - first]
            if straight and len(to) == int(self._stops[i]) - begin and i < len(self._blocks):
                self._read(i, to)
            else:
                to[:] = self._block(i)[k - begin : end - begin, columns]
            k = end
        return table

    def _begin(self, i: int) -> int:
        """Return the first row of a block."""
        return int(self._stops[i - 1]) if i else 0

    def _block(self, i: int) -> Array:
        if i == len(self._blocks):
            return self._rest
        if self._last is None or self._last[0] != i:
            rows = np.empty((int(self._stops[i]) - self._begin(i), self.shape[1]))
            self._read(i, rows)
            self._last = i, rows
        return self._last[1]

    def _read(self, i: int, rows: Array) -> None:
        """Read a block from disk into `rows`."""
        block = self._blocks[i]
        length = self._form.head_length() + block.size
        data = os.pread(self._file, length, block.start)
        try:
            records = self._form.records(data)
            self._form.read_rows(records, block.first, rows)
        except ValueError as error:
            begin, last = self._begin(i), int(self._stops[i]) - 1
            raise LogError(
                f"{self._name}: rows {begin} to {last} are damaged, or were changed since the log was opened, at byte "
                f"{block.start}; `cdpr repair` makes a complete log of the rows before them"
            ) from error


def _split(key: Any) -> tuple[Any, Any]:
    """Return the row and column indices in a key.

    Raises:
        IndexError: if it refers to other axes.
    """
    parts = key if isinstance(key, tuple) else (key,)
    parts = tuple(slice(None) if part is Ellipsis else part for part in parts)
    if len(parts) > 2 or any(part is None for part in parts):
        raise IndexError(
            f"rows of a run have two axes, rows and columns, got {len(parts)} indices with {short_repr(key)}"
        )
    rows, columns = (*parts, slice(None), slice(None))[:2]
    return rows, columns
