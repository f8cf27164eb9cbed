"""Conversion between rows and message bytes, many messages at a time.

All messages of one row have constant sizes, so the records of n rows differ from a template only in numbers at fixed
positions. The template is created once. A block is then written by copying columns into it, with one numpy assignment
for all columns and one for all times.
"""

from __future__ import annotations

import struct
from itertools import pairwise
from typing import TypeVar

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from cdpr.log.checksum import crc32
from cdpr.log.ros2 import ENCAPSULATION, encode
from cdpr.log.topics import Group
from cdpr.model.robot import Array

Bytes = NDArray[np.uint8]
Count = TypeVar("Count", int, NDArray[np.int64])

# opcode, length, first time, last time, size, crc, length of the compression's name (0), size
CHUNK_HEAD = struct.Struct("<BQQQQIIQ")
_MESSAGE_HEAD = struct.Struct("<BQH20x")  # opcode, length, channel; then the 20 bytes of number and times
_HEAD_NUMBER = 20  # bytes of number and times at its end
_INDEX_HEAD = struct.Struct("<BQHI")  # opcode, length, channel, length of the entries
_INDEX_ENTRY = 16
# Variable part of a message's head. In most messages the CDR begins with the stamp, so that it is contiguous.
_HEAD = np.dtype(
    [
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
        ("encapsulation", "<u4"),
        ("sec", "<i4"),
        ("nanosec", "<u4"),
    ]
)
_HEAD_STAMP = 24  # offset of the stamp


def nanoseconds(numbers: NDArray[np.int64], step: float) -> NDArray[np.uint64]:
    """Return the simulation times of the sample numbers, ns."""
    times: NDArray[np.uint64] = np.rint(numbers * step * 1e9).astype(np.uint64)
    return times


class Template:
    """Message records of one source row: constant bytes and the positions of the numbers."""

    def __init__(self, group: Group) -> None:
        data = bytearray()
        heads: list[tuple[int, int, int]] = []  # target byte, source byte, size
        values: list[tuple[int, int, int]] = []
        self.starts: list[int] = []  # start of each message's record
        for channel, topic in enumerate(group.topics, group.channel):
            cdr, places = encode(topic.kind, topic.value)
            self.starts.append(len(data))
            data += _MESSAGE_HEAD.pack(Opcode.MESSAGE, _MESSAGE_HEAD.size - 9 + len(cdr), channel)
            body = len(data)
            data += cdr
            stamps = [places[path] for path in topic.stamps]
            merged = stamps[:1] == [4]
            heads.append((body - _HEAD_NUMBER, 0, _HEAD.itemsize if merged else _HEAD_NUMBER))
            heads += [(body + place, _HEAD_STAMP, 8) for place in stamps[merged:]]
            for path, runs in topic.columns.items():
                place = body + places[path]
                for run in runs:
                    values.append((place, 8 * run.start, 8 * (run.stop - run.start)))
                    place += values[-1][2]
        copies = _joined(values)
        held = {column for _, start, size in copies for column in range(start // 8, (start + size) // 8)}
        self.unheld = [column for column in range(group.width) if column not in held]
        self.group = group
        self.row = np.frombuffer(data, np.uint8)
        # Number and times of a message equal those of the message before: their positions, and the distances.
        self.heads = np.array(self.starts[1:], np.int64) + (_MESSAGE_HEAD.size - _HEAD_NUMBER)
        self.before = np.diff(np.array(self.starts, np.int64))
        self.head_to, self.head_from = _view(heads, 0, len(data)), _view(heads, 1, _HEAD.itemsize)
        self.values_to, self.values_from = _view(copies, 0, len(data)), _view(copies, 1, 8 * group.width)

    def chunk_length(self, n: int) -> int:
        """Return the length of the record of a chunk with n rows, bytes."""
        return CHUNK_HEAD.size + n * self.row.size

    def index_length(self, n: Count) -> Count:
        """Return the length of each channel's message index after a chunk of n rows, bytes."""
        return _INDEX_HEAD.size + n * _INDEX_ENTRY

    def numbers(self, records: bytes | memoryview) -> NDArray[np.uint32]:
        """Return the sample numbers of the first messages of the rows in `records`, (n,)."""
        return np.frombuffer(records, np.uint8).reshape(-1, self.row.size)[:, 11:15].copy().view("<u4")[:, 0]

    def decode(self, records: bytes | memoryview, source: Array) -> None:
        """Decode the records of n rows into `source` (n, width), C-contiguous; columns without a message become NaN."""
        source[:, self.unheld] = np.nan
        source.view(self.values_from)[:, 0] = np.frombuffer(records, self.values_to)


def _joined(copies: list[tuple[int, int, int]]) -> list[tuple[int, int, int]]:
    """Return the copies (target byte, source byte, size) with contiguous neighbours merged."""
    joined: list[tuple[int, int, int]] = []
    for to, start, size in copies:
        if joined and (to, start) == (joined[-1][0] + joined[-1][2], joined[-1][1] + joined[-1][2]):
            to, start, size = joined[-1][0], joined[-1][1], joined.pop()[2] + size
        joined.append((to, start, size))
    return joined


def _view(copies: list[tuple[int, int, int]], side: int, size: int) -> np.dtype[np.void]:
    """Return one side of the copies as a structured type; one assignment between two sides performs all copies."""
    names = [str(i) for i in range(len(copies))]
    formats = [f"V{copy[2]}" for copy in copies]
    offsets = [copy[side] for copy in copies]
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": size})


class Chunk:
    """Buffer for one MCAP chunk of n rows and the message indexes that follow it."""

    def __init__(self, template: Template, n: int, step: float) -> None:
        group, row = template.group, template.row
        self._length, index_length = template.chunk_length(n), template.index_length(n)
        self._buffer = np.empty(self._length + len(group.topics) * index_length, np.uint8)
        self._records = self._buffer[CHUNK_HEAD.size : self._length]
        rows = self._records.reshape(n, row.size)
        rows[:] = row
        self._heads = np.zeros(n, _HEAD)
        self._heads["encapsulation"] = int.from_bytes(ENCAPSULATION, "little")
        self._heads_from = self._heads.view(template.head_from)
        self._heads_to = rows.view(template.head_to)[:, 0]
        self._values_to = rows.view(template.values_to)[:, 0]
        self._values_from = template.values_from
        index = self._buffer[self._length :].reshape(len(group.topics), index_length)
        entries = index[:, _INDEX_HEAD.size :].reshape(len(index), n, _INDEX_ENTRY)
        for i, start in enumerate(template.starts):
            _INDEX_HEAD.pack_into(
                index[i].data, 0, Opcode.MESSAGE_INDEX, index_length - 9, group.channel + i, n * _INDEX_ENTRY
            )
            entries[i, :, 8:].view("<u8")[:, 0] = start + row.size * np.arange(n)
        self._index_times = entries.view("<u8")[:, :, 0]
        self._bodies = [
            (start + _MESSAGE_HEAD.size, end) for start, end in pairwise([*template.starts, template.row.size])
        ]
        self._numbers = group.every * np.arange(n)
        self._step = step

    def messages(self, source: Array, sample: int) -> list[memoryview]:
        """Return the messages of one source row (1, width) of a sample, one per topic, as CDR.

        The chunk must have one row. The result is valid until the next call.
        """
        self._write(source, sample)
        data = self._records.data
        return [data[start:end] for start, end in self._bodies]

    def encode(self, source: Array, first: int) -> memoryview:
        """Return the bytes for the source rows of the samples first, first + every, ...

        The result is valid until the next call.
        """
        times = self._write(source, first)
        self._index_times[:] = times
        size = self._records.size
        crc = crc32(self._records.data)
        CHUNK_HEAD.pack_into(
            self._buffer.data,
            0,
            *(Opcode.CHUNK, self._length - 9, times[0], times[-1], size, crc, 0, size),
        )
        return self._buffer.data

    def _write(self, source: Array, first: int) -> NDArray[np.uint64]:
        """Write rows into the records, and return their times, ns."""
        numbers = self._numbers + first
        times = nanoseconds(numbers, self._step)
        heads = self._heads
        heads["sequence"] = numbers
        heads["log_time"] = times
        heads["publish_time"] = times
        heads["sec"], heads["nanosec"] = np.divmod(times, 10**9)
        self._heads_to[:] = self._heads_from
        self._values_to[:] = source.view(self._values_from)[:, 0]
        return times
