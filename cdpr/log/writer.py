"""Writes a log while the run goes on, such that a killed run leaves a readable file."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import numpy as np

from cdpr.errors import OutputError
from cdpr.log.chunk import CHUNK_HEAD
from cdpr.log.files import unwritable
from cdpr.log.mcap_file import BLOCK, PICTURE_ROWS, LogFormat, Written
from cdpr.log.rows import LogRows
from cdpr.log.run import Header
from cdpr.model.robot import Array


class LogWriter:
    """Appends rows to a log file.

    Each block goes to the operating system at once, with no buffer in between: it outlives this process.
    A block that is not yet full is written too, and written over as a longer one the next time; so the
    finished file does not depend on when it was flushed. After a failure every further call raises the same
    OutputError. Neither room reserved ahead nor a thread that writes made it faster where that was measured (ext4).

    `rows` is a C-contiguous table of all rows, or of the last ones: row k stands at k % len(rows), and a multiple of
    PICTURE_ROWS of them are there. The last row may have been sampled off the grid of `log_every`; the others not.

    Attributes:
        rows: once the file is closed, all rows, to be read from there when asked for; None unless `readable`. Those
            that it could not take are in memory.
    """

    def __init__(self, path: Path, header: Header, *, readable: bool = False) -> None:
        self.path = path
        self.rows: LogRows | None = None
        self._readable = readable
        self._format = LogFormat(header)
        self._every, self._step = header.log_every, header.control_step
        self._chunks: list[Written] = []  # what is never touched again: these chunks, ...
        self._rows = 0  # ... so many rows, ...
        self._pictured = 0  # ... the pictures of so many, ...
        self._end = 0  # ... so many bytes
        self._failure: OutputError | None = None
        try:
            self._file = path.open("w+b", buffering=0)
        except OSError as error:
            raise unwritable(path, error) from error
        try:
            self._append(self._format.description)
        except OutputError:
            self._file.close()
            raise

    def write(self, rows: Array | LogRows, stop: int) -> None:
        """Bring the file up to row `stop` (excluded), which is not the last of a thinned run."""
        while stop - self._rows >= BLOCK:
            self._append_block(rows, self._rows + BLOCK)
        if stop > self._rows:
            self._put_block(self._format.block(_cut(rows, self._rows, stop), self._rows * self._every))

    def so_far(self, rows: Array | LogRows, stop: int, last: Array) -> LogRows:
        """Return all rows up to row `stop` (excluded), and `last` (n, width) after them; the file is gone on with."""
        blocks = [chunk for chunk in self._chunks if chunk.group == 0]
        rest = rows[np.arange(self._rows, stop) % len(rows)]
        return LogRows(os.dup(self._file.fileno()), self._format, blocks, np.concatenate([rest, last]))

    def close(self, rows: Array | LogRows, stop: int) -> None:
        """Bring the file up to row `stop` (excluded) and make it complete; the second time, do nothing.

        What an exception cut short is gone on with by the next call.
        """
        if self._file.closed:
            if self._failure is not None:
                raise self._failure
            return
        try:
            self._complete(rows, stop)
        except OutputError:
            with contextlib.suppress(OSError):
                self._shut(rows, stop)
            raise
        try:
            self._shut(rows, stop)
        except OSError as error:
            raise self._fail(error) from error

    def _complete(self, rows: Array | LogRows, stop: int) -> None:
        last = self._sample(rows, stop - 1) if stop else 0
        regular = stop - 1 if last % self._every else stop  # rows on the grid
        while regular > self._rows:
            self._append_block(rows, min(regular, self._rows + BLOCK))
        if self._rows > self._pictured and self._rows == regular:
            self._append_pictures(rows)
        if stop > self._rows:
            self._append_block(rows, stop)
        self._put(self._format.ending(self._chunks, last, self._end))

    def _sample(self, rows: Array | LogRows, k: int) -> int:
        """Sample that row k is."""
        return k if self._every == 1 else round(float(rows[k % len(rows)][0]) / self._step)

    def _append_block(self, rows: Array | LogRows, stop: int) -> None:
        first = self._sample(rows, self._rows)
        written = Written(0, first, stop - self._rows, self._end)
        data = self._format.block(_cut(rows, self._rows, stop), first)
        self._put_block(data)
        self._count_in(data, written)
        self._rows = stop
        if stop % PICTURE_ROWS == 0 and first % self._every == 0:
            self._append_pictures(rows)

    def _append_pictures(self, rows: Array | LogRows) -> None:
        first = (self._rows - 1) // PICTURE_ROWS * PICTURE_ROWS
        data, written = self._format.pictures(_cut(rows, first, self._rows), first * self._every, self._end)
        self._append(data, *written)
        self._pictured = self._rows

    def _append(self, data: bytes | memoryview, *written: Written) -> None:
        self._put(data)
        self._count_in(data, *written)

    def _count_in(self, data: bytes | memoryview, *written: Written) -> None:
        self._end += len(data)
        self._chunks += written

    def _put_block(self, data: memoryview) -> None:
        """Write the rows, then the head that says how many: killed in between, the shorter block before it stays."""
        self._put(data[CHUNK_HEAD.size :], CHUNK_HEAD.size)
        self._put(data[: CHUNK_HEAD.size])

    def _put(self, data: bytes | memoryview, beyond: int = 0) -> None:
        if self._failure is not None:
            raise self._failure
        rest = memoryview(data)
        try:
            self._file.seek(self._end + beyond)
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            raise self._fail(error) from error

    def _fail(self, error: OSError) -> OutputError:
        self._failure = unwritable(self.path, error)
        return self._failure

    def _shut(self, rows: Array | LogRows, stop: int) -> None:
        if self._readable and self.rows is None:
            self.rows = self.so_far(rows, stop, rows[:0])
        self._file.close()


def _cut(rows: Array | LogRows, first: int, stop: int) -> Array:
    """Rows first to stop - 1 of the run, which lie side by side in the table."""
    begin = first % len(rows)
    return rows[begin : begin + stop - first]
