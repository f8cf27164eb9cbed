"""Writes a log while the run goes on, such that a killed run leaves a readable file."""

from __future__ import annotations

import contextlib
from pathlib import Path

from cdpr.errors import OutputError
from cdpr.log.files import unwritable
from cdpr.log.mcap_file import BLOCK, PICTURE_ROWS, LogFormat, Written
from cdpr.log.run import Header
from cdpr.model.robot import Array


class LogWriter:
    """Appends rows to a log file.

    Each block goes to the operating system in one write, with no buffer in between: it outlives this process.
    A block that is not yet full is written too, and written over as a longer one the next time; so the
    finished file does not depend on when it was flushed. After a failure every further call raises the same
    OutputError.
    """

    def __init__(self, path: Path, header: Header) -> None:
        self.path = path
        self._format = LogFormat(header)
        self._chunks: list[Written] = []  # what is never touched again: these chunks, ...
        self._rows = 0  # ... so many rows, ...
        self._end = 0  # ... so many bytes
        self._failure: OutputError | None = None
        try:
            self._file = path.open("wb", buffering=0)
        except OSError as error:
            raise unwritable(path, error) from error
        self._append(self._format.description)

    def write(self, rows: Array, stop: int) -> None:
        """Bring the file up to row `stop` (excluded) of the run's C-contiguous `rows`."""
        while stop - self._rows >= BLOCK:
            self._append_block(rows, self._rows + BLOCK)
        if stop > self._rows:
            self._put(self._format.block(rows[self._rows : stop], self._rows))

    def close(self, rows: Array, stop: int) -> None:
        """Bring the file up to row `stop` (excluded) and make it complete; the second time, do nothing."""
        if self._file.closed and self._failure is None:
            return
        while stop > self._rows:
            self._append_block(rows, min(stop, self._rows + BLOCK))
        if stop % PICTURE_ROWS:
            self._append_pictures(rows)
        self._append(self._format.ending(self._chunks, stop, self._end))
        try:
            self._file.close()
        except OSError as error:
            raise self._fail(error) from error

    def _append_block(self, rows: Array, stop: int) -> None:
        written = Written(0, self._rows, stop - self._rows, self._end)
        self._append(self._format.block(rows[self._rows : stop], self._rows))
        self._chunks.append(written)
        self._rows = stop
        if stop % PICTURE_ROWS == 0:
            self._append_pictures(rows)

    def _append_pictures(self, rows: Array) -> None:
        first = (self._rows - 1) // PICTURE_ROWS * PICTURE_ROWS
        data, written = self._format.pictures(rows[first : self._rows], first, self._end)
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
            self._file.close()
        return self._failure
