"""Index of a complete log: the chunks that its ending names, without a look at them."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

from mcap.opcode import Opcode

from cdpr.log.mcap_file import DATA_END, MAGIC, LogFormat, Written

_FOOTER = struct.Struct(f"<BQQQI{len(MAGIC)}s")
_RECORD = struct.Struct("<BQ")  # opcode, length
# Of a chunk index: first and last time, start and length of the chunk, length of the list of channels, first channel
_CHUNK_INDEX = struct.Struct("<QQQQIH")
_SIZES = struct.Struct("<QQ")  # its last numbers: sizes of the records, as stored and uncompressed


@dataclass(frozen=True)
class Index:
    """Chunks of a log."""

    chunks: tuple[Written, ...]
    end: int  # byte behind the last of them
    rows: int  # in the blocks

    @property
    def blocks(self) -> list[Written]:
        """The chunks with the rows."""
        return [chunk for chunk in self.chunks if chunk.group == 0]


def read_index(file: BinaryIO, form: LogFormat) -> Index | None:
    """Return the index of a log, None where its ending is not, to the byte, what would be written for these chunks."""
    size = os.fstat(file.fileno()).st_size
    if size < len(form.description) + _FOOTER.size:
        return None
    file.seek(size - _FOOTER.size)
    opcode, _, summary, _, _, magic = _FOOTER.unpack(file.read())
    if opcode != Opcode.FOOTER or magic != MAGIC or not len(form.description) < summary < size:
        return None
    file.seek(summary - len(DATA_END))
    if file.read(len(form.ending_start)) != form.ending_start:  # a wrong place, from which on the whole log may follow
        return None
    file.seek(summary)
    try:
        chunks, last, end = _chunks(file.read(), form)
    except (struct.error, LookupError, ValueError):
        return None
    file.seek(end)
    expected = form.ending(chunks, last, end)
    if end + len(expected) != size or file.read() != expected:
        return None
    return Index(tuple(chunks), end, sum(chunk.n for chunk in chunks if chunk.group == 0))


def _chunks(summary: bytes, form: LogFormat) -> tuple[list[Written], int, int]:
    """Return the chunks that a summary names, the last sample, and the byte behind the last chunk.

    Raises ValueError, LookupError or struct.error where it is not one of this format.
    """
    groups = {template.group.channel: i for i, template in enumerate(form.templates)}
    counts = [0] * len(groups)
    chunks, last, end = [], 0, len(form.description)
    for content in _records(summary, Opcode.CHUNK_INDEX):
        first_time, _, start, _, _, channel = _CHUNK_INDEX.unpack_from(content)
        stored, size = _SIZES.unpack_from(content, len(content) - _SIZES.size)
        group = groups[channel]
        template = form.templates[group]
        n, rest = divmod(size, template.row.size)
        first = counts[group] * template.group.every
        if group == 0 and n == 1 and form.every > 1:  # perhaps the last sample of a thinned run, off the grid
            first = min(first, round(first_time / 1e9 / form.step))
        if rest or n == 0 or start != end:
            raise ValueError("not an index of this format")
        chunks.append(Written(group, first, n, start, stored))
        counts[group] += n
        end += form.length(chunks[-1])
        if group == 0:
            last = first + (n - 1) * template.group.every
    return chunks, last, end


def _records(data: bytes, kind: int) -> Iterator[bytes]:
    """Yield the contents of the records of one kind."""
    place = 0
    while place + _RECORD.size <= len(data):
        opcode, length = _RECORD.unpack_from(data, place)
        place += _RECORD.size
        if opcode == kind:
            yield data[place : place + length]
        place += length
