"""File with the images of a run's cameras, beside its log."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from cdpr.log.checksum import crc32
from cdpr.log.files import unwritable
from cdpr.log.images import BEGINS, KIND, CameraImages, cameras_of, imaged_rows, message, png
from cdpr.log.ros2 import full_name, schema_text
from cdpr.log.run import Run
from cdpr.log.run_json import log_of
from cdpr.log.sensor_topics import frame_of

if TYPE_CHECKING:
    from mcap.reader import McapReader

IMAGES_NAME = "images.mcap"  # in a run folder
OF_LOG = "cdpr.log"  # name of the metadata that identify the log of the images
BLOCK = 1 << 20  # bytes that are read at once

# Records at the end of MCAP files, with the checksums of what is before them: https://mcap.dev/spec#footer-op0x02.
DATA_END = struct.Struct("<BQI")  # 15, length, CRC-32 of the file before it
FOOTER = struct.Struct("<BQQQI8s")  # 2, length, places of the summary and of its offsets, CRC-32, magic number
BEFORE_CRC = 12  # bytes from the CRC-32 in the footer to the end of the file
MAGIC = b"\x89MCAP0\r\n"


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
            writer = Writer(file, compression=CompressionType.NONE, enable_data_crcs=True)  # PNG is compressed
            writer.start(profile="ros2", library="cdpr")
            writer.add_metadata(OF_LOG, _identity(run))
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


def _identity(run: Run) -> dict[str, str]:
    """Return what identifies the log of a run."""
    return {key: str(value) for key, value in asdict(log_of(run.header, run.rows)).items()}


@contextmanager
def stored_images(run: Run) -> Iterator[McapReader | None]:
    """Open the images in the folder of a run for `StoredTopic`; yields None without a complete file of this run."""
    path = None if run.folder is None else Path(run.folder) / IMAGES_NAME
    try:
        file = path.open("rb") if path is not None and path.is_file() else None
    except OSError:
        file = None
    if file is None:
        yield None
        return
    with file:
        reader = None
        with suppress(OSError):
            if _is_whole(file):
                file.seek(0)
                reader = make_reader(file)
                known = {each.name: each.metadata for each in reader.iter_metadata()}
                reader = reader if known.get(OF_LOG) == _identity(run) else None
        yield reader


def _is_whole(file: BinaryIO) -> bool:
    """Return True if the checksums in an MCAP file are those of its content."""
    size = file.seek(0, 2)
    if size < FOOTER.size:
        return False
    file.seek(size - FOOTER.size)
    _, _, summary, _, known, magic = FOOTER.unpack(file.read(FOOTER.size))
    data_end = summary - DATA_END.size
    if magic != MAGIC or not 0 < data_end < size - FOOTER.size:
        return False
    file.seek(data_end)
    _, _, known_data = DATA_END.unpack(file.read(DATA_END.size))
    found = _crc(file, 0, data_end), _crc(file, summary, size - BEFORE_CRC)
    return found == (known_data, known)


def _crc(file: BinaryIO, first: int, end: int) -> int:
    """Return the CRC-32 of the bytes [first, end) of a file."""
    file.seek(first)
    value = 0
    for place in range(first, end, BLOCK):
        value = crc32(file.read(min(BLOCK, end - place)), value)
    return value


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
    with stored_images(run) as found:
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
