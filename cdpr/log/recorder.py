"""Recorder of a run's rows: in memory or, for long logged runs, in the log."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cdpr.base.errors import Diverged, OutputError
from cdpr.log.blocks import BLOCK, BLOCK_SECONDS
from cdpr.log.finite import Finite
from cdpr.log.header import Header
from cdpr.log.mcap_file import LOG_NAME, PICTURE_ROWS
from cdpr.log.pages import table
from cdpr.log.rows import IN_MEMORY, LogRows
from cdpr.log.summary import Accumulator
from cdpr.log.writer import LogWriter
from cdpr.model.robot import Array

if TYPE_CHECKING:
    from cdpr.log.image_writer import ImageWriter
    from cdpr.mechanics.closest import Closest


@dataclass(frozen=True, eq=False)
class Piece:
    """Samples kept between two snapshots.

    Attributes:
        first, rows: index of the first row among the kept ones, and the rows.
        counted, status: the same for the solver statuses of a tally.
        before: previous piece.
    """

    first: int
    rows: Array
    counted: int
    status: NDArray[np.int8]
    before: Piece | None

    def line(self) -> Iterator[Piece]:
        """Yield this piece and all previous ones."""
        here: Piece | None = self
        while here is not None:
            yield here
            here = here.before


@dataclass(frozen=True, eq=False)
class RecorderSnapshot:
    """Snapshot of a recorder: its data of the samples up to `stop` (excluded)."""

    stop: int
    piece: Piece
    last: Array  # (1, width), sample before `stop`; empty at the start
    tally: Accumulator | None
    marked: dict[int, Array]


class Recorder:
    """Rows of a run of `steps` steps, and their log if a run folder is given.

    The loop writes sample k into `rows[k % len(rows)]` itself, one copy per step; its time is k * control_step. After n
    samples it must call `flush(n)` if `n % BLOCK == 0`, and also half a second after the last call. At the end it calls
    `close(n)`. Without a folder, nothing is written.

    Every sample is kept or, if the header has a `log_every`, every such sample from the first on, and the last. Kept
    samples stay in memory unless they are large (IN_MEMORY) and logged. The `tally` counts all samples.

    Args:
        marks: samples whose rows are also kept in `marked`.
        closest: factory of the clearance monitor, which may return None; called only if there is a tally.
        images: writer of the images of cameras, which the caller closes.

    Attributes:
        rows: table for the samples of the loop.
        first: first sample that may be in `rows`.

    Raises:
        OutputError: if the log cannot be written; no sample is lost, because the rest stays in memory.
        Diverged: by `flush`, if a sample is not finite; `finite` reports it after `close`, too.
    """

    def __init__(
        self,
        header: Header,
        steps: int,
        folder: Path | None = None,
        marks: Iterable[int] = (),
        closest: Callable[[], Closest | None] = lambda: None,
        images: ImageWriter | None = None,
    ) -> None:
        width, self._every = header.layout.width, header.log_every
        self._status = header.layout.columns["status"].start
        kept = steps // self._every + (2 if steps % self._every else 1)
        self._on_disk = on_disk = folder is not None and 8 * width * kept > IN_MEMORY
        self._kept: Array = table(min(kept, PICTURE_ROWS) if on_disk else kept, width)
        thinned = table(min(steps + 1, PICTURE_ROWS), width) if self._every > 1 else None
        self.rows: Array = self._kept if thinned is None else thinned
        self._writer = None if folder is None else LogWriter(folder / LOG_NAME, header, readable=on_disk)
        self.tally = Accumulator(header, steps + 1, closest()) if on_disk or thinned is not None else None
        self.finite = Finite(header.layout, header.control_step)
        self.marked: dict[int, Array] = {}
        self._marks = sorted(set(marks))
        self._images = images
        self.first = 0
        self._piece: Piece | None = None  # last snapshot of the current branch
        self._count = 0  # number of kept rows: row i is sample i * every, except for the last
        self._written = monotonic()
        self._failure: OutputError | None = None

    def flush(self, stop: int) -> None:
        """Process the samples up to `stop` (excluded), and update the log."""
        self._take(stop)
        self._image()
        if self._writer is not None and (self._every == 1 or monotonic() > self._written + BLOCK_SECONDS):
            self._write()
            self._written = monotonic()
        if self._failure is not None:
            raise self._failure
        if self.finite.fault:
            raise Diverged(self.finite.fault)

    def amend(self, header: Header, marks: Iterable[int]) -> None:
        """Set a header with other broken cables, and the marks of future samples."""
        self._marks = sorted(set(marks))
        if self.tally is not None:
            self.tally.amend(header)
        if self._images is not None:
            self._images.amend(header)

    def snapshot(self, stop: int) -> RecorderSnapshot:
        """Return a snapshot of the samples up to `stop` (excluded) for `restore`, without rows only on disk."""
        self._take(stop)
        tally, before = self.tally, self._piece
        first = before.first + len(before.rows) if before else 0
        counted = before.counted + len(before.status) if before else 0
        if tally is not None:
            self._tally_up(stop)
            tally = tally.copy()
        rows = self._kept[first : 0 if self._on_disk else self._count].copy()
        status = np.empty(0, np.int8) if tally is None else tally.status[counted:].copy()
        self._piece = Piece(first, rows, counted, status, before)
        last = np.arange(max(stop - 1, 0), stop) % len(self.rows)
        return RecorderSnapshot(stop, self._piece, self.rows[last], tally, dict(self.marked))

    def restore(self, taken: RecorderSnapshot) -> None:
        """Restore a snapshot of this recorder, or of one of the same run with another log."""
        tally = None if taken.tally is None else taken.tally.copy()
        known = set(self._piece.line()) if self._piece else set()
        for piece in taken.piece.line():
            if piece in known:
                break
            self._kept[piece.first : piece.first + len(piece.rows)] = piece.rows
            if tally is not None:
                tally.put(piece.counted, piece.status)
        self._piece, self.tally, self.marked = taken.piece, tally, dict(taken.marked)
        self._count = taken.piece.first + len(taken.piece.rows)
        last = taken.stop - len(taken.last)
        self.rows[np.arange(last, taken.stop) % len(self.rows)] = taken.last
        self.first = 0 if self.rows is self._kept else last
        self.finite.rewind(taken.stop)

    def close(self, stop: int) -> Array | LogRows:
        """Process the last samples up to `stop` (excluded), complete the log, and return the rows of the run."""
        self._take(stop)
        if stop and (stop - 1) % self._every and self._count <= (stop - 1) // self._every + 1:
            self._kept[self._count % len(self._kept)] = self.rows[(stop - 1) % len(self.rows)]
            self._count += 1
        self._image()
        if self.tally is not None:
            self._tally_up(stop)
        if self._writer is not None:
            self._writer.close(self._kept, self._count)
        return self.kept

    def so_far(self, stop: int) -> Array | LogRows:
        """Return the rows that the run would have if it ended before sample `stop`; the recorder remains usable."""
        self._take(stop)
        if self.tally is not None:
            self._tally_up(stop)
        off = stop > 0 and (stop - 1) % self._every > 0
        last = self.rows[[(stop - 1) % len(self.rows)]] if off else self.rows[:0]
        if self._on_disk and self._writer is not None:
            return self._writer.so_far(self._kept, self._count, last)
        return np.concatenate([self._kept[: self._count], last])

    @property
    def on_disk(self) -> bool:
        """True if samples are kept only in the log."""
        return self._on_disk

    @property
    def kept(self) -> Array | LogRows:
        """Result of `close`, even if it failed."""
        on_disk = None if self._writer is None else self._writer.rows
        return self._kept[: self._count] if on_disk is None else on_disk

    @property
    def status(self) -> NDArray[np.generic]:
        """Solver status of each sample, (K,); valid after `close`."""
        return self.rows[: self._count, self._status] if self.tally is None else self.tally.status

    def _take(self, stop: int) -> None:
        """Keep samples up to `stop`; a repeated call after an interrupt is harmless."""
        size, every = len(self.rows), self._every
        self.finite.take(self.rows, stop)
        for k in self._marks:
            if k < stop and k not in self.marked:
                self.marked[k] = self.rows[k % size].copy()
        if every == 1:
            self._count = stop
        while self._count * every < stop:
            first, at = self._count * every % size, self._count % len(self._kept)
            there = -(-min(stop - self._count * every, size - first) // every)  # before the table wraps around
            n = min(there, len(self._kept) - at, BLOCK - self._count % BLOCK)
            self._kept[at : at + n] = self.rows[first : first + (n - 1) * every + 1 : every]
            self._count += n
            if self._writer is not None and self._count % BLOCK == 0:
                self._image()
                self._write()
        if stop % size == 0 and self.tally is not None:
            self._tally_up(stop)

    def _image(self) -> None:
        """Pass kept rows on for images."""
        if self._images is not None:
            self._images.take(self._kept, self._count)

    def _write(self) -> None:
        """Write kept rows to the log; `flush` and `close` report a failure after all samples are kept."""
        assert self._writer is not None
        try:
            self._writer.write(self._kept, self._count)
        except OutputError as failure:
            self._failure = failure

    def _tally_up(self, stop: int) -> None:
        """Count the uncounted samples in the table, up to `stop`."""
        assert self.tally is not None
        first = self.tally.count % len(self.rows)
        self.tally.add(self.rows[first : first + stop - self.tally.count])
