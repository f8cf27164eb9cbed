"""Writes a log while the run goes on, such that a killed run leaves a readable file."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from cdpr.errors import OutputError
from cdpr.log.files import unwritable
from cdpr.log.mcap_file import BLOCK, PICTURE_ROWS, LogFormat, Written
from cdpr.log.rows import LogRows
from cdpr.log.run import Header
from cdpr.model.robot import Array


class LogWriter:
    """Appends rows to a log file.

    Each block goes to the operating system in one write, with no buffer in between: it outlives this process.
    A block that is not yet full is written too, and written over as a longer one the next time; so the
    finished file does not depend on when it was flushed. After a failure every further call raises the same
    OutputError.

    `rows` is a C-contiguous table of all rows, or of the last ones: row k stands at k % len(rows), and a multiple of
    PICTURE_ROWS of them are there. The last row may have been sampled off the grid of `log_every`; the others not.

    Attributes:
        rows: once the file is closed, its rows, to be read from there when asked for; None unless `readable`.
    """

    def __init__(self, path: Path, header: Header, *, readable: bool = False) -> None:
        self.path = path
        self.rows: LogRows | None = None
        self._readable = readable
        self._format = LogFormat(header)
        self._every, self._step = header.log_every, header.control_step
        self._chunks: list[Written] = []  # what is never touched again: these chunks, ...
        self._rows = 0  # ... so many rows, ...
        self._end = 0  # ... so many bytes
        self._failure: OutputError | None = None
        try:
            self._file = path.open("w+b", buffering=0)
        except OSError as error:
            raise unwritable(path, error) from error
        self._append(self._format.description)

    def write(self, rows: Array | LogRows, stop: int) -> None:
        """Bring the file up to row `stop` (excluded), which is not the last of a thinned run."""
        while stop - self._rows >= BLOCK:
            self._append_block(rows, self._rows + BLOCK)
        if stop > self._rows:
            self._put(self._format.block(_cut(rows, self._rows, stop), self._rows * self._every))

    def close(self, rows: Array | LogRows, stop: int) -> None:
        """Bring the file up to row `stop` (excluded) and make it complete; the second time, do nothing."""
        if self._file.closed and self._failure is None:
            return
        last = self._sample(rows, stop - 1) if stop else 0
        regular = stop - 1 if last % self._every else stop  # rows on the grid
        while regular > self._rows:
            self._append_block(rows, min(regular, self._rows + BLOCK))
        if regular % PICTURE_ROWS:
            self._append_pictures(rows)
        if stop > regular:
            self._append_block(rows, stop)
        self._append(self._format.ending(self._chunks, last, self._end))
        try:
            self._shut()
        except OSError as error:
            raise self._fail(error) from error

    def _sample(self, rows: Array | LogRows, k: int) -> int:
        """Sample that row k is."""
        return k if self._every == 1 else round(float(rows[k % len(rows)][0]) / self._step)

    def _append_block(self, rows: Array | LogRows, stop: int) -> None:
        first = self._sample(rows, self._rows)
        written = Written(0, first, stop - self._rows, self._end)
        self._append(self._format.block(_cut(rows, self._rows, stop), first))
        self._chunks.append(written)
        self._rows = stop
        if stop % PICTURE_ROWS == 0 and first % self._every == 0:
            self._append_pictures(rows)

    def _append_pictures(self, rows: Array | LogRows) -> None:
        first = (self._rows - 1) // PICTURE_ROWS * PICTURE_ROWS
        data, written = self._format.pictures(_cut(rows, first, self._rows), first * self._every, self._end)
        self._append(data)
        self._chunks += written

    def _append(self, data: bytes | memoryview) -> None:
        self._put(data)
        self._end += len(data)

    def _put(self, data: bytes | memoryview) -> None:
        if self._failure is not None:
            raise self._failure
        rest = memoryview(data)
        try:
            self._file.seek(self._end)
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            raise self._fail(error) from error

    def _fail(self, error: OSError) -> OutputError:
        self._failure = unwritable(self.path, error)
        with contextlib.suppress(OSError):
            self._shut()
        return self._failure

    def _shut(self) -> None:
        if self._readable and self.rows is None:
            blocks = [chunk for chunk in self._chunks if chunk.group == 0]
            self.rows = LogRows(os.dup(self._file.fileno()), self._format, blocks)
        self._file.close()


def _cut(rows: Array | LogRows, first: int, stop: int) -> Array:
    """Rows first to stop - 1 of the run, which lie side by side in the table."""
    begin = first % len(rows)
    return rows[begin : begin + stop - first]
