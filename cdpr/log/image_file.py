"""File with the images of a run's cameras, beside its log."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Self

from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import Message
from mcap.writer import CompressionType, Writer

from cdpr.log.files import unwritable
from cdpr.log.header import Header
from cdpr.log.images import BEGINS, KIND, CameraImages, cameras_of, every_row, message, png, sample_of
from cdpr.log.ros2 import full_name, schema_text
from cdpr.log.run import Run
from cdpr.log.run_folder import IMAGES_NAME
from cdpr.log.sensor_topics import frame_of
from cdpr.model.robot import Array

if TYPE_CHECKING:
    from mcap.reader import McapReader

CHUNK = 1 << 16  # bytes of messages that a killed run may lose: few images


class ImageFile:
    """File with the images of all cameras as `sensor_msgs/CompressedImage` (PNG), in the order of their rows.

    Equal runs give equal bytes on one machine. Images that are added are in the file, even if the process is killed.

    Args:
        path: new file.
        header: header of the run.
        before: messages of an incomplete file of the same run, which are not rendered again.

    Raises:
        OutputError: if it cannot be written.
    """

    def __init__(self, path: Path, header: Header, before: Iterator[tuple[str, Message]] | None = None) -> None:
        self._path, self._header = path, header
        self._before = iter(()) if before is None else before
        self._next = next(self._before, None)
        try:
            self._file = path.open("xb")
            self._writer = Writer(self._file, chunk_size=CHUNK, compression=CompressionType.NONE)  # PNG is compressed
            self._writer.start(profile="ros2", library="cdpr")
            self._schema = self._writer.register_schema(full_name(KIND), "ros2msg", schema_text(KIND).encode())
        except OSError as error:
            raise unwritable(path, error) from error
        self._channels: dict[str, int] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Complete the file; after an error, leave it incomplete."""
        try:
            with self._file:
                if kind is None:
                    self._writer.finish()  # type: ignore[no-untyped-call]
        except OSError as error:
            raise unwritable(self._path, error) from error

    def add(self, cameras: Iterable[CameraImages], row: Array) -> None:
        """Add the images of a row (width,), of those cameras that take one then.

        Raises:
            OutputError: if they cannot be written.
            CdprError: if the renderer fails.
        """
        sample = sample_of(self._header, row)
        if sample is None:
            return
        time = round(sample * self._header.control_step * 1e9)
        for camera in cameras:
            if sample % camera.every:
                continue
            data = self._stored(camera.topic, time)
            if data is None:
                data = message(time, frame_of(camera.name), png(camera.image(row)))
            if camera.topic not in self._channels:
                self._channels[camera.topic] = self._writer.register_channel(camera.topic, "cdr", self._schema)
            try:
                self._writer.add_message(self._channels[camera.topic], time, data, time, sample)
                self._file.flush()
            except OSError as error:
                raise unwritable(self._path, error) from error

    def _stored(self, topic: str, time: int) -> bytes | None:
        """Return the next message of the incomplete file, if it is this one."""
        if self._next is None or (self._next[0], self._next[1].log_time) != (topic, time):
            return None
        data = self._next[1].data
        self._next = next(self._before, None)
        return data


@contextmanager
def stored_images(folder: str | None) -> Iterator[McapReader | None]:
    """Open the images in the folder of a run for `StoredTopic`; yields None without a complete file."""
    try:
        file = None if folder is None else (Path(folder) / IMAGES_NAME).open("rb")
    except OSError:
        file = None
    if file is None:
        yield None
        return
    with file:
        try:
            reader = make_reader(file)
            complete = reader.get_summary() is not None
        except (McapError, struct.error, ValueError, OSError):
            complete = False
        yield reader if complete else None


class StoredTopic:
    """Stored images on one topic, which are read in the order of their times."""

    def __init__(self, reader: McapReader, topic: str) -> None:
        self._messages = (found for _, _, found in reader.iter_messages(topics=[topic]))
        self._last = next(self._messages, None)

    def at(self, time: int) -> bytes | None:
        """Return the PNG file of a time, ns, not before that of the last call; None if there is none."""
        while self._last is not None and self._last.log_time < time:
            self._last = next(self._messages, None)
        if self._last is None or self._last.log_time != time:
            return None
        return self._last.data[self._last.data.index(BEGINS) :]


def complete_images(run: Run) -> Path | None:
    """Write the images of a run with cameras whose folder has no complete file of them, as after it was killed.

    Returns:
        The file, if it was written.

    Raises:
        OutputError: if it cannot be written.
        CdprError: if no renderer works on this machine.
    """
    if run.folder is None or not len(run.rows) or not (cameras := cameras_of(run.header)):
        return None
    path = Path(run.folder) / IMAGES_NAME
    with stored_images(run.folder) as found:
        if found is not None:
            return None
    part = path.with_suffix(".part")
    try:
        part.unlink(missing_ok=True)
        with ImageFile(part, run.header, _messages(path)) as file:
            for _, row in every_row(run, cameras):
                file.add(cameras, row)
        part.replace(path)
    except OSError as error:
        raise unwritable(path, error) from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        for camera in cameras:
            camera.close()
    return path


def _messages(path: Path) -> Iterator[tuple[str, Message]]:
    """Yield topics and messages of an incomplete file, up to the first that is not whole."""
    with suppress(McapError, struct.error, ValueError, OSError), path.open("rb") as file:
        for _, channel, found in NonSeekingReader(file).iter_messages(log_time_order=False):
            yield channel.topic, found
