"""Thread that renders the images of a run's cameras while it runs, and writes them to their file."""

from __future__ import annotations

from pathlib import Path
from queue import Full, Queue
from threading import Event, Thread

from cdpr.base.errors import CdprError
from cdpr.log.header import Header
from cdpr.log.image_file import ImageFile
from cdpr.log.images import cameras_of, rows_apart
from cdpr.model.robot import Array

QUEUE = 4096  # rows that wait for their images: a few megabytes; with more, the run waits
POLL = 0.1  # s, between two checks whether a thread has ended


class ImageWriter:
    """Images of a running simulation.

    The thread makes and uses the renderers. It may be behind the run, and `close` waits for it. A killed run leaves the
    images that were written, of which `complete_images` makes a complete file.

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
        self._queue: Queue[Array | Header | None] = Queue(QUEUE)
        self._failure: BaseException | None = None
        self._ready = Event()
        self._thread = Thread(target=self._run, args=(path, header), daemon=True, name="images")
        self._thread.start()
        while not self._ready.wait(POLL):  # a wait without end would ignore interrupts
            pass
        self._raise()

    def take(self, rows: Array, stop: int) -> None:
        """Take the rows before `stop` for images; row k is at k % len(rows)."""
        first = -(-self._taken // self._stride) * self._stride
        for k in range(first, stop, self._stride):
            self._put(rows[k % len(rows)].copy())
        self._taken = max(self._taken, stop)

    def amend(self, header: Header) -> None:
        """Show the cables as broken that a header of the same run states, in the rows that are taken from now on."""
        if header.broken != self._broken:
            self._broken = header.broken
            self._put(header)

    def close(self) -> None:
        """Wait for the remaining images, and complete the file; again after an interrupt.

        Raises:
            OutputError: if they could not be written.
            CdprError: if the renderer failed.
        """
        self._put(None)
        while self._thread.is_alive():
            self._thread.join(POLL)
        self._raise()

    def _put(self, item: Array | Header | None) -> None:
        while self._thread.is_alive():
            try:
                self._queue.put(item, timeout=POLL)
                return
            except Full:
                continue

    def _raise(self) -> None:
        if isinstance(self._failure, CdprError):
            raise self._failure
        if self._failure is not None:
            raise CdprError(f"the images cannot be rendered: {self._failure}") from self._failure

    def _run(self, path: Path, header: Header) -> None:
        try:
            self._write(path, header)
        except BaseException as error:
            self._failure = error
        self._ready.set()

    def _write(self, path: Path, header: Header) -> None:
        try:
            for camera in self._cameras:
                _ = camera.renderer
            with ImageFile(path, header) as file:
                self._ready.set()
                while (item := self._queue.get()) is not None:
                    if isinstance(item, Header):
                        self._cameras = [camera.revised(item) for camera in self._cameras]
                    else:
                        file.add(self._cameras, item)
        finally:
            for camera in self._cameras:
                camera.close()
