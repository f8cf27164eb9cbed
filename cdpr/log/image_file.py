"""File with the images of a run's cameras, beside its log."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from cdpr.log.files import unwritable
from cdpr.log.images import BEGINS, KIND, CameraImages, cameras_of, imaged_rows, message, png
from cdpr.log.ros2 import full_name, schema_text
from cdpr.log.run import Run
from cdpr.log.sensor_topics import frame_of

if TYPE_CHECKING:
    from mcap.reader import McapReader

IMAGES_NAME = "images.mcap"  # in a run folder


def write_images(path: Path, run: Run, cameras: list[CameraImages]) -> None:
    """Write the images of all cameras as `sensor_msgs/CompressedImage` (PNG) to an MCAP file; they are rendered here.

    Equal runs give equal bytes on one machine.

    Args:
        path: new file.
        run: run with rows.
        cameras: cameras of the run.

    Raises:
        OutputError: if it cannot be written; it is then removed.
        CdprError: if the renderer fails.
    """
    try:
        with path.open("xb") as file:
            writer = Writer(file, compression=CompressionType.NONE)  # PNG is compressed
            writer.start(profile="ros2", library="cdpr")
            schema = writer.register_schema(full_name(KIND), "ros2msg", schema_text(KIND).encode())
            for camera in cameras:
                channel = writer.register_channel(camera.topic, "cdr", schema)
                for sample, row in imaged_rows(run, camera):
                    time = round(sample * run.header.control_step * 1e9)
                    data = message(time, frame_of(camera.name), png(camera.image(row)))
                    writer.add_message(channel, time, data, time, sample)
            writer.finish()  # type: ignore[no-untyped-call]
    except BaseException as error:
        with suppress(OSError):
            path.unlink()
        if isinstance(error, OSError):
            raise unwritable(path, error) from error
        raise


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
    try:
        for camera in cameras:
            _ = camera.renderer  # before the incomplete file is removed
        with suppress(FileNotFoundError):
            path.unlink()
        write_images(path, run, cameras)
    except OSError as error:
        raise unwritable(path, error) from error
    finally:
        for camera in cameras:
            camera.close()
    return path
