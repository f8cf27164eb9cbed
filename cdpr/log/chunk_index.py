"""ChunkIndex records of a log: positions of chunks and of each channel's messages in them.

All records of a group of topics have the same length, so that a few numpy assignments create those of many chunks: an
hour at 1 kHz has 16 700 of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from cdpr.log.chunk import Bytes, Count, Template, nanoseconds

RECORD_HEAD = 9  # opcode and length
CHANNEL = RECORD_HEAD + 36  # offset of the first channel in a record


class Written(NamedTuple):
    """One chunk of the file."""

    group: int  # index of the group of topics
    first: int  # sample of its first messages
    n: int  # number of source rows
    start: int  # start of its record, byte
    size: int  # size of its records in the file, bytes


class ChunkIndex:
    """ChunkIndex records of the chunks of one group of topics.

    Args:
        template: template of the group's messages.
        head: size of a chunk's record before its messages, bytes.
        compression: name of the compression.
        step: control step, s.
    """

    def __init__(self, template: Template, head: int, compression: bytes, step: float) -> None:
        group = template.group
        self._template, self._head, self._step = template, head, step
        self.channel = group.channel  # first channel
        self._channels = np.arange(group.channel, group.channel + len(group.topics))
        place = np.dtype([("channel", "<u2"), ("start", "<u8")])
        self.record = np.dtype(
            [
                ("opcode", "u1"),
                ("length", "<u8"),
                ("first_time", "<u8"),
                ("last_time", "<u8"),
                ("start", "<u8"),
                ("chunk_length", "<u8"),
                ("places_size", "<u4"),
                ("places", place, (len(self._channels),)),
                ("indexes_size", "<u8"),
                ("name_size", "<u4"),
                ("name", np.uint8, (len(compression),)),
                ("size", "<u8"),
                ("raw_size", "<u8"),
            ]
        )
        self._constant = np.zeros(1, self.record)
        self._constant["opcode"] = Opcode.CHUNK_INDEX
        self._constant["length"] = self.record.itemsize - RECORD_HEAD
        self._constant["places_size"] = len(self._channels) * place.itemsize
        self._constant["places"]["channel"] = self._channels
        self._constant["name_size"] = len(compression)
        self._constant["name"] = list(compression)

    def length(self, n: Count, size: Count) -> Count:
        """Return the size of chunks of `n` rows with `size` bytes of messages, including their indexes, bytes."""
        return self._head + size + len(self._channels) * self._template.index_length(n)

    def records(self, chunks: Sequence[Written]) -> Bytes:
        """Return the records of these chunks, (chunks, bytes)."""
        first, n, start, size = np.array(chunks, np.int64)[:, 1:].T
        records = np.repeat(self._constant, len(chunks))
        records["first_time"] = nanoseconds(first, self._step)
        records["last_time"] = nanoseconds(first + (n - 1) * self._template.group.every, self._step)
        records["start"] = start
        records["chunk_length"] = self._head + size
        lengths = self._template.index_length(n)  # of each channel's message index
        behind = start + self._head + size
        records["places"]["start"] = behind[:, None] + lengths[:, None] * np.arange(len(self._channels))
        records["indexes_size"] = len(self._channels) * lengths
        records["size"] = size
        records["raw_size"] = n * self._template.row.size
        return records.view(np.uint8).reshape(len(chunks), -1)

    def read(self, data: Bytes, places: NDArray[np.int64], group: int) -> NDArray[np.int64]:
        """Return the fields of `Written`, (chunks, 5), from the records of a group at these positions.

        Raises:
            ValueError: if a record does not belong to this group.
        """
        if len(places) and places[-1] + self.record.itemsize > len(data):
            raise ValueError("cut off")
        records = data[places[:, None] + np.arange(self.record.itemsize)].view(self.record)[:, 0]
        n, rest = np.divmod(records["raw_size"].astype(np.int64), self._template.row.size)
        if rest.any() or (n <= 0).any():
            raise ValueError("not an index of this format")
        first = self._template.group.every * (np.cumsum(n) - n)
        if group == 0 and len(n) and n[-1] == 1:  # possibly the last sample of a thinned run, off the grid
            first[-1] = min(first[-1], round(float(records["first_time"][-1]) / 1e9 / self._step))
        start, size = records["start"].astype(np.int64), records["size"].astype(np.int64)
        return np.stack([np.full(len(n), group), first, n, start, size], axis=1)


def chunk_indexes(layouts: Sequence[ChunkIndex], chunks: Sequence[Written]) -> bytes:
    """Return the records of chunks of all groups, in order."""
    groups = np.array([chunk.group for chunk in chunks], np.int64)
    ends = np.cumsum(np.array([layout.record.itemsize for layout in layouts])[groups])
    data = np.empty(ends[-1] if len(chunks) else 0, np.uint8)
    for group, layout in enumerate(layouts):
        chosen = np.flatnonzero(groups == group)
        if len(chosen):
            size = layout.record.itemsize
            places = (ends[chosen] - size)[:, None] + np.arange(size)
            data[places] = layout.records([chunks[i] for i in chosen.tolist()])
    return data.tobytes()
