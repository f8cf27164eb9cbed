"""File of a log during a run: a thread encodes, compresses and appends chunks."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Literal

from cdpr.base.errors import OutputError, one_line
from cdpr.log.chunk import CHUNK_HEAD
from cdpr.log.chunk_index import Written
from cdpr.log.files import require_process, unwritable
from cdpr.log.mcap_file import LogFormat, Piece

QUEUE = 2  # pending jobs of the thread, including the current one; the caller waits before it adds another

Kind = Literal["rows", "pictures"]


class ChunkFile:
    """New file to which chunks are appended.

    One thread writes everything in the order of the calls, which return earlier. The file is unbuffered: written data
    survives this process. After a failure, every further call raises the same OutputError. `chunks`, `end` and `done`
    describe the content of the file; read them only after `wait`.

    Attributes:
        chunks: all chunks.
        end: end of the last chunk, byte.
        done: number of rows in chunks, and number of rows with pictures.
    """

    def __init__(self, path: Path, form: LogFormat) -> None:
        """Create the file with its description.

        Raises:
            OutputError: if it cannot be written.
        """
        self._path, self._form = path, form
        self.chunks: list[Written] = []
        self.end = 0
        self.done: dict[Kind, int] = {"rows": 0, "pictures": 0}
        self._size = 0  # of the file; larger than `end` if an incomplete block follows
        self._failure: OutputError | None = None
        self._pending: deque[Future[None]] = deque()
        try:
            self.file = path.open("w+b", buffering=0)
        except OSError as error:
            raise unwritable(path, error) from error
        try:
            self._put([form.description], 0)
        except OutputError:
            self.file.close()
            raise
        self.end = self._size = len(form.description)
        self._thread = ThreadPoolExecutor(1, "log")
        self._process = os.getpid()

    def wait(self, left: int = 0) -> None:
        """Wait until at most `left` calls are pending.

        Raises:
            OutputError: if one of the others failed.
        """
        require_process(self._process, self._path)
        error: BaseException | None = None
        while len(self._pending) > left:
            found = self._pending[0].exception()
            self._pending.popleft()
            error = error or found
        error = error or self._failure
        if error is not None:
            raise error

    def append(self, kind: Kind, stop: int, make: Callable[[], Sequence[Piece]]) -> None:
        """Append the chunks that `make` returns; the file then contains this kind up to row `stop` (excluded).

        The thread calls `make`. A repeated call for the same rows, after an interrupt, has no effect.
        """
        self._begin(lambda: self._append(kind, stop, make))

    def put_tail(self, make: Callable[[], memoryview]) -> None:
        """Write the incomplete block that `make` returns, uncompressed, and wait until it is written.

        If the block has grown, the rows are written before the head with their number, so that a kill in between leaves
        the shorter block valid.
        """
        self._begin(lambda: self._put_tail(make()))
        self.wait()

    def finish(self, ending: bytes) -> None:
        """Write the end of the file; a repeated call after an interrupt is harmless."""

        def put() -> None:
            self._put([ending], self.end)
            self._cut(self.end + len(ending))

        self._begin(put)
        self.wait()

    def close(self) -> None:
        """Stop the thread and close the file.

        Raises:
            OSError: if closing fails.
        """
        if os.getpid() == self._process:  # forks have no such thread
            self._thread.shutdown()
        self.file.close()

    def _begin(self, job: Callable[[], None]) -> None:
        self.wait(QUEUE - 1)
        try:
            self._pending.append(self._thread.submit(self._run, job))
        except RuntimeError:  # no thread can start, such as during interpreter shutdown
            self.wait()
            self._run(job)

    def _run(self, job: Callable[[], None]) -> None:
        try:
            job()
        except OutputError:
            raise
        except Exception as error:  # such as MemoryError; later blocks would leave a gap in the file
            self._failure = OutputError(f"{self._path}: cannot be written: {one_line(error)}")
            raise self._failure from error

    def _append(self, kind: Kind, stop: int, make: Callable[[], Sequence[Piece]]) -> None:
        if stop <= self.done[kind]:
            return
        chunks, end = [], self.end
        for piece in make():
            stored, written = self._form.stored(piece, end)
            self._put(stored, end)
            chunks.append(written)
            end += sum(map(len, stored))
        if self._size > self.end:
            self._cut(end)
        self._size = end
        self.chunks += chunks
        self.end, self.done[kind] = end, stop

    def _put_tail(self, raw: memoryview) -> None:
        start, stop = self.end + self._form.gap, 9 + int.from_bytes(raw[1:9], "little")
        if os.fstat(self.file.fileno()).st_size != self._size:  # repaired meanwhile, without file locks
            self._cut(self.end)
        self._put([raw[CHUNK_HEAD.size : stop]], start + CHUNK_HEAD.size)
        self._put([raw[: CHUNK_HEAD.size]], start)
        self._size = start + stop

    def _cut(self, end: int) -> None:
        """Truncate the file at a byte: removes an incomplete block whose rows are now in a chunk."""
        try:
            self.file.truncate(end)
        except OSError as error:
            raise self._fail(error) from error

    def _put(self, parts: Sequence[bytes | memoryview], start: int) -> None:
        if self._failure is not None:
            raise self._failure
        try:
            self.file.seek(start)
            for part in parts:
                rest = memoryview(part)
                while rest:
                    rest = rest[self.file.write(rest) :]
        except OSError as error:
            raise self._fail(error) from error

    def _fail(self, error: OSError) -> OutputError:
        self._failure = unwritable(self._path, error)
        return self._failure
