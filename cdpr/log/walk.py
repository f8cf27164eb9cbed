"""Verification of a log, chunk by chunk.

A row is accepted only if its chunk equals, bit for bit, the chunk that would be written for its rows. This test covers
the checksum, numbers, times and all constant bytes.
"""

from __future__ import annotations

import os
from typing import BinaryIO

import numpy as np
from mcap.opcode import Opcode

from cdpr.log.blocks import BLOCK
from cdpr.log.chunk import CHUNK_HEAD
from cdpr.log.chunk_index import Written
from cdpr.log.compression import compressed_head
from cdpr.log.mcap_file import LogFormat
from cdpr.log.rows import LogRows
from cdpr.model.robot import Array

_CHANNEL, _NUMBER = slice(9, 11), slice(11, 15)  # in the first message of a chunk


class _DamageError(Exception):
    """Damage or premature end of the log."""


class Walk:
    """Traversal of the chunks of a log, from the first to the ending or to the first damage.

    Args:
        file: the log.
        form: its format.
        memory: limit of the rows in memory, bytes; larger tables stay in the file.

    Attributes:
        chunks: valid chunks.
        position: end of the last chunk, byte.
        tail: number of rows in an incomplete block after them.
    """

    def __init__(self, file: BinaryIO, form: LogFormat, memory: int) -> None:
        self._file = file
        self._form = form
        self._size = os.fstat(file.fileno()).st_size
        self._memory = memory
        self.position = len(form.description)
        self.chunks: list[Written] = []
        self.tail = 0
        self._counts = [0] * len(form.templates)  # source rows so far, by group
        self._last = -1  # last sample read
        self._blocks: list[Array] | None = []  # None if they exceed the memory limit
        self._tail = np.empty((0, form.templates[0].group.width))

    def rows(self, name: str) -> Array | LogRows:
        """Return the rows found; `name` is the log's name for messages."""
        if self._blocks is None:
            chunks = [chunk for chunk in self.chunks if chunk.group == 0]
            return LogRows(os.dup(self._file.fileno()), self._form, chunks, self._tail, name=name)
        return np.concatenate([self._tail[:0], *self._blocks, self._tail])

    def run(self) -> str | None:
        """Read all chunks; return the defect, or None if the log is valid."""
        self._file.seek(self.position)
        try:
            while True:
                head = self._take(CHUNK_HEAD.size)
                if head[0] != Opcode.CHUNK:
                    break
                self._chunk(head)
            expected = self._form.ending(self.chunks, self._last, self.position)
            if head + self._file.read(len(expected)) != expected:
                raise _DamageError("damaged or cut off")
        except _DamageError as damage:
            self._read_tail()
            return f"{damage} at byte {self.position} of {self._size}"
        return None

    def _chunk(self, head: bytes) -> None:
        length = 9 + int.from_bytes(head[1:9], "little")
        data = head + self._take(length - len(head))
        try:
            records = self._form.records(data)
        except ValueError as error:
            raise _DamageError("damaged") from error
        channel = int.from_bytes(records[_CHANNEL], "little")
        groups = [i for i, template in enumerate(self._form.templates) if template.group.channel == channel]
        if not groups:
            raise _DamageError("damaged")
        template, group = self._form.templates[groups[0]], groups[0]
        n, rest = divmod(len(records), template.row.size)
        if rest or n == 0:
            raise _DamageError("damaged")
        size = length - self._form.head_length()
        written = Written(group, self._counts[group] * template.group.every, n, self.position, size)
        index: bytes | None = None
        if group == 0:
            written = self._sampled(written, records)
            raw = self._verified(data, records, written)
            self._last = written.first + (n - 1) * template.group.every
            index = bytes(raw[CHUNK_HEAD.size + len(records) :])
        self._counts[group] += n
        self.chunks.append(written)
        index_length = len(template.group.topics) * template.index_length(n)
        if index not in (self._take(index_length), None):
            raise _DamageError("damaged")
        self.position += length + index_length

    def _verified(self, data: bytes, records: bytes | memoryview, written: Written) -> memoryview:
        """Keep the rows of a valid block, and return the block as it would be written, uncompressed."""
        block = np.empty((written.n, self._form.templates[0].group.width))
        try:
            self._form.read_rows(records, written.first, block)
        except ValueError as error:
            raise _DamageError("damaged") from error
        raw = self._form.block(block, written.first)
        head: bytes | memoryview = raw[: CHUNK_HEAD.size]
        if self._form.compressor is not None:
            head = compressed_head(raw, written.size)
        if data[: len(head)] != head or raw[CHUNK_HEAD.size : CHUNK_HEAD.size + len(records)] != records:
            raise _DamageError("damaged")
        self._keep(block)
        return raw

    def _sampled(self, written: Written, records: bytes | memoryview) -> Written:
        """Return the chunk with its first sample: the next of the grid, except for the last sample of a thinned run."""
        every = self._form.every
        if self._last >= 0 and self._last % every:
            raise _DamageError("damaged")
        number = int.from_bytes(records[_NUMBER], "little")
        off_grid = written.n == 1 and self._last < number < written.first
        return written._replace(first=number) if off_grid else written

    def _read_tail(self) -> None:
        """Read an incomplete block after the last chunk."""
        form, template = self._form, self._form.templates[0]
        start = self.position + form.gap
        if form.compressor is None or self._last % form.every or start + CHUNK_HEAD.size > self._size:
            return
        self._file.seek(start)
        head = self._file.read(CHUNK_HEAD.size)
        length = 9 + int.from_bytes(head[1:9], "little")
        n, rest = divmod(length - CHUNK_HEAD.size, template.row.size)
        if head[0] != Opcode.CHUNK or rest or not 0 < n < BLOCK or start + length > self._size:
            return
        data = head + self._file.read(length - len(head))
        first = self._counts[0] * form.every
        rows = np.empty((n, template.group.width))
        try:
            form.read_rows(form.records(data, tail=True), first, rows)
        except ValueError:
            return
        if form.block(rows, first)[:length] == data:
            self._tail, self.tail = rows, n

    def _keep(self, block: Array) -> None:
        if self._blocks is not None:
            self._blocks.append(block)
            if self._counts[0] * block[0].nbytes + block.nbytes > self._memory:
                self._blocks = None

    def _take(self, size: int) -> bytes:
        left = self._size - self._file.tell()
        if size < 0:
            raise _DamageError("damaged")
        if size > left:
            raise _DamageError("cut off")
        return self._file.read(size)
