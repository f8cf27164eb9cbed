"""Index of a complete log: the chunks listed at its end, without reading them."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
from mcap.opcode import Opcode

from cdpr.log.chunk_index import CHANNEL, Written
from cdpr.log.mcap_file import DATA_END, MAGIC, LogFormat

_FOOTER = struct.Struct(f"<BQQQI{len(MAGIC)}s")
_RECORD = struct.Struct("<BQ")  # opcode, length


@dataclass(frozen=True)
class Index:
    """Chunks of a log."""

    chunks: tuple[Written, ...]
    end: int  # end of the last chunk, byte
    rows: int  # total number in the blocks

    @property
    def blocks(self) -> list[Written]:
        """Chunks with the rows."""
        return [chunk for chunk in self.chunks if chunk.group == 0]


def read_index(file: BinaryIO, form: LogFormat) -> Index | None:
    """Return the index of a log; None if its end is not exactly the one expected for these chunks."""
    size = os.fstat(file.fileno()).st_size
    if size < len(form.description) + _FOOTER.size:
        return None
    file.seek(size - _FOOTER.size)
    opcode, _, summary, _, _, magic = _FOOTER.unpack(file.read())
    if opcode != Opcode.FOOTER or magic != MAGIC or not len(form.description) < summary < size:
        return None
    file.seek(summary - len(DATA_END))
    if file.read(len(form.ending_start)) != form.ending_start:  # a wrong offset; the rest of the log may follow there
        return None
    file.seek(summary)
    try:
        chunks, last, end = _chunks(file.read(), form)
    except ValueError:
        return None
    if end + len(DATA_END) != summary:
        return None
    file.seek(end)
    expected = form.ending(chunks, last, end)
    if end + len(expected) != size or file.read() != expected:
        return None
    return Index(tuple(chunks), end, sum(chunk.n for chunk in chunks if chunk.group == 0))


def _chunks(summary: bytes, form: LogFormat) -> tuple[list[Written], int, int]:
    """Return the chunks in a summary, the last sample, and the end of the last chunk.

    Raises:
        ValueError: if the summary does not have this format.
    """
    data = np.frombuffer(summary, np.uint8)
    places = np.array(list(_places(summary, Opcode.CHUNK_INDEX)), np.int64)
    channels = data[places[:, None] + CHANNEL + np.arange(2)].view("<u2")[:, 0]
    table = np.full((len(places), 5), -1)  # fields of Written
    for group, layout in enumerate(form.indexes):
        chosen = np.flatnonzero(channels == layout.channel)
        table[chosen] = layout.read(data, places[chosen], group)
    lengths = np.zeros(len(places), np.int64)
    for group, layout in enumerate(form.indexes):
        chosen = table[:, 0] == group
        lengths[chosen] = layout.length(table[chosen, 2], table[chosen, 4])
    ends = len(form.description) + np.cumsum(lengths)
    if (table[:, 0] < 0).any() or (table[:, 3] != ends - lengths).any():
        raise ValueError("not an index of this format")
    chunks = list(map(Written._make, table.tolist()))
    rows = [chunk for chunk in chunks if chunk.group == 0]
    last = rows[-1].first + (rows[-1].n - 1) * form.every if rows else 0
    return chunks, last, int(ends[-1]) if len(ends) else len(form.description)


def _places(data: bytes, kind: int) -> Iterator[int]:
    """Yield the offsets of the records of one kind."""
    place = 0
    while place + _RECORD.size <= len(data):
        opcode, length = _RECORD.unpack_from(data, place)
        if opcode == kind:
            yield place
        place += _RECORD.size + length
