"""Thread that renders the images of a run's cameras while it runs, and writes them to their file."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from queue import Empty, Queue
from threading import Event, Thread
from time import monotonic, sleep

from cdpr.base.errors import CdprError
from cdpr.base.interrupts import WAITING
from cdpr.log.header import Header
from cdpr.log.image_file import ImageFile
from cdpr.log.images import cameras_of, rows_apart, sample_of
from cdpr.model.robot import Array

QUEUE = 4096  # rows that wait for their images: a few megabytes; with more, the run waits
POLL = 0.1  # s, between two checks whether a thread has ended
MOMENT = 0.01  # s, between two checks whether there is room for a row
PATIENCE = 0.5  # s of waiting for images before the user is informed


class _SkippedError(Exception):
    """End of the thread without the remaining images."""


class ImageWriter:
    """Images of a running simulation.

    The thread makes and uses the renderers. It may be behind the run, and `close` waits for it. A killed run leaves the
    images that were written, of which `complete_images` makes a complete file; so does an interrupt during `close`.
    If the renderer fails during the run, a warning is issued at the next row, and the run continues without images.

    Args:
        path: new file.
        header: header of the run.

    Raises:
        OutputError: if the file cannot be created.
        CdprError: if no renderer works on this machine.
    """

    def __init__(self, path: Path, header: Header) -> None:
        self._cameras = cameras_of(header)
        self._stride = rows_apart(header, self._cameras)
        self._taken = 0  # rows
        self._broken = header.broken
        self._queue: Queue[Array | Header | None] = Queue()
        self._ending = False  # the run does not wait any more
        self._failure: BaseException | None = None
        self._warned = False
        self._skip = Event()
        self._skipped = 0  # images
        self._ready = Event()
        self._ended = Event()  # an interrupt of `Thread.join` would mark a running thread as ended
        self._thread = Thread(target=self._run, args=(path, header), daemon=True, name="images")
        self._thread.start()
        while not self._ready.wait(POLL):  # a wait without end would ignore interrupts
            pass
        self._raise()

    def take(self, rows: Array, stop: int) -> None:
        """Take the rows before `stop` for images; row k is at k % len(rows)."""
        if self._failure is not None and not self._warned:
            self._warned = True
            warnings.warn(f"{self._error()}; the run continues, without further images", stacklevel=2)
        if self._ended.is_set():
            return
        first = -(-self._taken // self._stride) * self._stride
        stopped: KeyboardInterrupt | None = None
        for k in range(first, stop, self._stride):
            try:
                self._wait_for_room()
            except KeyboardInterrupt as interrupt:  # take these rows nevertheless
                self._ending, stopped = True, interrupt
            self._queue.put(rows[k % len(rows)].copy())
            self._taken = k + 1
        self._taken = max(self._taken, stop)
        if stopped is not None:
            raise stopped

    def amend(self, header: Header) -> None:
        """Show the cables as broken that a header of the same run states, in the rows that are taken from now on."""
        if header.broken != self._broken:
            self._broken = header.broken
            self._queue.put(header)

    def close(self, report: Callable[[int], None] = lambda images: None) -> int:
        """Wait for the remaining images, and complete the file; return the number of skipped images.

        An interrupt skips the remaining images, which leaves the file incomplete; call `close` again after it.

        Args:
            report: function that is called once with the number of remaining images, if they take long.

        Raises:
            OutputError: if they could not be written.
            CdprError: if the renderer failed.
        """
        due = None if self._skip.is_set() else monotonic() + PATIENCE
        try:
            with WAITING:
                self._queue.put(None)
                while not self._ended.wait(POLL):
                    if due is not None and monotonic() > due:
                        due = None
                        report(self._remaining())
        except KeyboardInterrupt:
            self._skip.set()
            raise
        self._raise()
        return self._skipped

    def _remaining(self) -> int:
        """Return the number of images of the waiting rows."""
        with self._queue.mutex:
            rows = [item for item in self._queue.queue if item is not None and not isinstance(item, Header)]
        cameras = self._cameras
        samples = [sample_of(cameras[0].header, row) for row in rows]
        return sum(sample % camera.every == 0 for sample in samples if sample is not None for camera in cameras)

    def _wait_for_room(self) -> None:
        """Wait until the thread is not far behind; an interrupt ends the waiting at once."""
        if self._queue.qsize() < QUEUE or self._ending:
            return
        with WAITING:
            while self._queue.qsize() >= QUEUE and not self._ended.is_set():
                sleep(MOMENT)

    def _raise(self) -> None:
        if isinstance(self._failure, CdprError):
            raise self._failure
        if self._failure is not None:
            raise CdprError(self._error()) from self._failure

    def _error(self) -> str:
        failure = self._failure
        return str(failure) if isinstance(failure, CdprError) else f"the images cannot be rendered: {failure}"

    def _next(self) -> Array | Header | None:
        """Return the next item; it is still in the queue if the remaining ones are skipped."""
        while True:
            if self._skip.is_set() and self._remaining():
                raise _SkippedError
            try:
                return self._queue.get(timeout=POLL)
            except Empty:
                continue

    def _run(self, path: Path, header: Header) -> None:
        try:
            self._write(path, header)
        except _SkippedError:
            self._skipped = self._remaining()
        except BaseException as error:
            self._failure = error
        finally:
            self._ready.set()
            self._ended.set()

    def _write(self, path: Path, header: Header) -> None:
        try:
            for camera in self._cameras:
                _ = camera.renderer
            with ImageFile(path, header) as file:
                self._ready.set()
                while (item := self._next()) is not None:
                    if isinstance(item, Header):
                        self._cameras = [camera.revised(item) for camera in self._cameras]
                    else:
                        file.add(self._cameras, item)
        finally:
            for camera in self._cameras:
                camera.close()
