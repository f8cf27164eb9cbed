"""Log writer for a running simulation; a killed run leaves a readable file."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import numpy as np

from cdpr.base.errors import OutputError
from cdpr.log.blocks import BLOCK
from cdpr.log.chunk_file import ChunkFile
from cdpr.log.files import unwritable
from cdpr.log.header import Header
from cdpr.log.layout import Rows
from cdpr.log.mcap_file import PICTURE_ROWS, LogFormat, Piece
from cdpr.log.rows import LogRows
from cdpr.model.robot import Array


class LogWriter:
    """Log file to which rows are appended.

    A thread writes complete blocks during the run, at most QUEUE blocks late. An incomplete block is written before
    `write` returns, and again with more rows the next time, so that the finished file does not depend on the times of
    flushing. Errors of the thread are raised by a later call, at the latest by `close`, and by every further one.

    `rows` is a C-contiguous table of all rows, or of the last ones: row k is at k % len(rows), and the table's length
    is then a multiple of PICTURE_ROWS, so that no row is overwritten while the thread reads it. Only the last row may
    be off the grid of `log_every`.

    Attributes:
        rows: after closing, all rows, read from the file on access; None unless `readable`. Rows that could not be
            written are in memory.
    """

    def __init__(self, path: Path, header: Header, *, readable: bool = False) -> None:
        self.path = path
        self.rows: LogRows | None = None
        self._readable = readable
        self._format = LogFormat(header)
        self._every, self._step = header.log_every, header.control_step
        self._rows = 0  # rows passed on as blocks
        self._pictured = 0  # rows passed on as pictures
        self.out = ChunkFile(path, self._format)
        self._closed = False

    def write(self, rows: Array | Rows, stop: int) -> None:
        """Write the rows up to `stop` (excluded), which must not include the last one of a thinned run."""
        while stop - self._rows >= BLOCK:
            self._append_block(rows, self._rows + BLOCK)
        if stop > self._rows:
            part, first = _cut(rows, self._rows, stop), self._rows * self._every
            self.out.put_tail(lambda: self._format.block(part, first))

    def so_far(self, rows: Array | Rows, stop: int, last: Array) -> LogRows:
        """Return all rows up to `stop` (excluded), followed by `last` (n, width); the file remains open."""
        with contextlib.suppress(OutputError):  # rows that could not be written are in memory
            self.out.wait()
        blocks = [chunk for chunk in self.out.chunks if chunk.group == 0]
        rest = rows[np.arange(self.out.done["rows"], stop) % len(rows)]
        file = os.dup(self.out.file.fileno())
        return LogRows(file, self._format, blocks, np.concatenate([rest, last]), name=str(self.path))

    def close(self, rows: Array | Rows, stop: int) -> None:
        """Write the rows up to `stop` (excluded) and complete the file; do nothing if it is complete.

        After an exception, the next call continues.
        """
        if self._closed:
            self.out.wait()  # raises pending errors
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
            raise unwritable(self.path, error) from error

    def _complete(self, rows: Array | Rows, stop: int) -> None:
        last = self._sample(rows, stop - 1) if stop else 0
        regular = stop - 1 if last % self._every else stop  # rows on the grid
        while regular > self._rows:
            self._append_block(rows, min(regular, self._rows + BLOCK))
        if self._rows > self._pictured and self._rows == regular:
            self._append_pictures(rows)
        if stop > self._rows:
            self._append_block(rows, stop)
        self.out.wait()
        self.out.finish(self._format.ending(self.out.chunks, last, self.out.end))

    def _sample(self, rows: Array | Rows, k: int) -> int:
        """Return the sample number of row k."""
        return k if self._every == 1 else round(float(rows[k % len(rows)][0]) / self._step)

    def _append_block(self, rows: Array | Rows, stop: int) -> None:
        first, part = self._sample(rows, self._rows), _cut(rows, self._rows, stop)
        self.out.append("rows", stop, lambda: [Piece(0, first, len(part), self._format.block(part, first))])
        self._rows = stop
        if stop % PICTURE_ROWS == 0 and first % self._every == 0:
            self._append_pictures(rows)

    def _append_pictures(self, rows: Array | Rows) -> None:
        first = (self._rows - 1) // PICTURE_ROWS * PICTURE_ROWS
        pieces = self._format.pictures(_cut(rows, first, self._rows), first * self._every)
        self.out.append("pictures", self._rows, lambda: pieces)
        self._pictured = self._rows

    def _shut(self, rows: Array | Rows, stop: int) -> None:
        if self._readable and self.rows is None:
            self.rows = self.so_far(rows, stop, rows[:0])
        self._closed = True
        self.out.close()


def _cut(rows: Array | Rows, first: int, stop: int) -> Array:
    """Return rows first to stop - 1 of the run, which are contiguous in the table."""
    begin = first % len(rows)
    return rows[begin : begin + stop - first]
