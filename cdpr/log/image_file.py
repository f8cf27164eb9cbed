"""File with the images of a run's cameras, beside its log."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Self

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import Message
from mcap.writer import CompressionType, Writer

from cdpr.log.checksum import crc32
from cdpr.log.files import unwritable
from cdpr.log.header import Header
from cdpr.log.images import (
    BEGINS,
    KIND,
    CameraImages,
    cameras_of,
    every_row,
    message,
    png,
    rows_apart,
    sample_of,
    takes_images,
)
from cdpr.log.ros2 import full_name, schema_text
from cdpr.log.run import Run
from cdpr.log.run_folder import IMAGES_NAME
from cdpr.log.sensor_topics import frame_of
from cdpr.model.robot import Array

if TYPE_CHECKING:
    from mcap.reader import McapReader

CHUNK = 1 << 16  # bytes of messages that a killed run may lose: few images
# Names of the metadata that identify the log of the images: first its scenario, last the row of the last images.
SCENARIO, LAST = "cdpr.scenario", "cdpr.last_row"
BLOCK = 1 << 20  # bytes that are read at once

# Records at the end of MCAP files, with the checksums of what is before them: https://mcap.dev/spec#footer-op0x02.
DATA_END = struct.Struct("<BQI")  # 15, length, CRC-32 of the file before it
FOOTER = struct.Struct("<BQQQI8s")  # 2, length, places of the summary and of its offsets, CRC-32, magic number
BEFORE_CRC = 12  # bytes from the CRC-32 in the footer to the end of the file
MAGIC = b"\x89MCAP0\r\n"


class ImageFile:
    """File with the images of all cameras as `sensor_msgs/CompressedImage` (PNG), in the order of their rows.

    Equal runs give equal bytes on one machine. If the process is killed, the file lacks only the last images that were
    added, up to `CHUNK` bytes.

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
            self._writer = Writer(  # PNG is compressed
                self._file, chunk_size=CHUNK, compression=CompressionType.NONE, enable_data_crcs=True
            )
            self._writer.start(profile="ros2", library="cdpr")
            self._writer.add_metadata(SCENARIO, _scenario(header))
            self._schema = self._writer.register_schema(full_name(KIND), "ros2msg", schema_text(KIND).encode())
        except OSError as error:
            raise unwritable(path, error) from error
        self._channels: dict[str, int] = {}
        self._last: Array | None = None  # row of the last images

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Complete the file; after an error, leave it incomplete."""
        try:
            with self._file:
                if kind is None:
                    self._writer.add_metadata(LAST, _of_row(self._last))
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
            self._last = row

    def _stored(self, topic: str, time: int) -> bytes | None:
        """Return the next message of the incomplete file, if it is this one."""
        if self._next is None or (self._next[0], self._next[1].log_time) != (topic, time):
            return None
        data = self._next[1].data
        self._next = next(self._before, None)
        return data


def _scenario(header: Header) -> dict[str, str]:
    """Return what identifies the scenario of a log."""
    return {"crc32": str(crc32(header.scenario_yaml.encode(errors="backslashreplace")))}


def _of_row(row: Array | None) -> dict[str, str]:
    """Return what identifies a row (width,); None if there are no images."""
    return {"crc32": "" if row is None else str(crc32(np.ascontiguousarray(row, dtype="<f8").tobytes()))}


def _last_row(run: Run) -> Array | None:
    """Return the row (width,) of the last images of a run."""
    cameras = cameras_of(run.header)
    for k in reversed(range(0, len(run.rows), rows_apart(run.header, cameras))):
        row: Array = np.asarray(run.rows[k : k + 1])[0]
        if takes_images(run.header, row, cameras):
            return row
    return None


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
                same = known.get(SCENARIO) == _scenario(run.header) and known.get(LAST) == _of_row(_last_row(run))
                reader = reader if same else None
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
    part = path.with_suffix(".part")
    try:
        part.unlink(missing_ok=True)
        with ImageFile(part, run.header, _messages(path, run.header)) as file:
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


def _messages(path: Path, header: Header) -> Iterator[tuple[str, Message]]:
    """Yield topics and messages of an incomplete file of this run, up to the first that is not whole."""
    if not path.is_file():  # nothing, or a pipe
        return
    with suppress(McapError, struct.error, ValueError, OSError), path.open("rb") as file:
        first = next(NonSeekingReader(file).iter_metadata(), None)
        if first is None or (first.name, first.metadata) != (SCENARIO, _scenario(header)):
            return
        file.seek(0)
        for _, channel, found in NonSeekingReader(file, validate_crcs=True).iter_messages(log_time_order=False):
            yield channel.topic, found
