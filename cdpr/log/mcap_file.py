"""Layout of the log file. Equal header and rows give equal bytes.

    description   MCAP header, metadata "cdpr" (the run's Header as JSON), schemas, channels, scenario.yaml
    blocks        256 rows each: one chunk with every message of these rows, and its message indexes
    pictures      after each 16 blocks and at the end: the chunks of /clock and /tf, and of /cdpr/markers, for these
                  rows
    ending        data end, summary, footer

Chunks are compressed by zstd. While a run goes on, a block that is not yet full stands behind the last chunk at a
distance of `LogFormat.gap`, uncompressed and without indexes: the full block is written before it, and never over it.

Only the description and the blocks are needed to get the run back; `FORMATS` counts the changes to them.
In format 3 nothing was compressed, and a block that was not yet full stood where the full one would.
In format 2 blocks held /clock, and /cdpr/cable_commands where it is what /cdpr/cable_states says, too.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass

import numpy as np
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode

from cdpr.log.checksum import crc32
from cdpr.log.chunk import CHUNK_HEAD, Chunk, Template
from cdpr.log.chunk_index import ChunkIndex, Written, chunk_indexes
from cdpr.log.compression import NAME, ZSTD_HEAD, Compressor, decompress, largest
from cdpr.log.ros2 import schema_text
from cdpr.log.run import Header
from cdpr.log.topics import run_topics
from cdpr.log.visuals import visual_topics
from cdpr.model.robot import Array

FORMATS = ("2", "3", "4")  # that are read; the last is written
UNCOMPRESSED = ("2", "3")
LOG_NAME = "log.mcap"  # of a run folder
MAGIC = b"\x89MCAP0\r\n"
BLOCK = 256  # rows in a full block
PICTURE_ROWS = 16 * BLOCK  # rows of the run whose pictures share chunks: few, for they are not needed at once
METADATA = "cdpr"
ATTACHMENT = "scenario.yaml"


@dataclass(frozen=True)
class Piece:
    """One chunk that is to be written."""

    group: int
    first: int
    n: int
    raw: memoryview  # the chunk, uncompressed, and its message indexes


class LogFormat:
    """Every byte of a log that belongs to one Header.

    A reader gives the `text` that it found for the header, which may be an older version's, and the format.
    """

    def __init__(self, header: Header, text: str | None = None, version: str = FORMATS[-1]) -> None:
        repeated = version == "2"
        main = run_topics(header, repeated=repeated)
        groups = (main, *visual_topics(header, main.channel + len(main.topics), clock=not repeated))
        self.templates = tuple(Template(group) for group in groups)  # the rows' own, then the pictures'
        self.step = header.control_step
        self.every = header.log_every
        self._time = header.layout.columns["time"].start
        self._full_block: Chunk | None = None
        self.compressor = None if version in UNCOMPRESSED else Compressor()
        name = b"" if self.compressor is None else NAME
        self.indexes = [ChunkIndex(template, self.head_length(), name, self.step) for template in self.templates]
        topics = [topic for group in groups for topic in group.topics]
        kinds = list(dict.fromkeys(topic.kind for topic in topics))
        self._schemas = [
            _bytes(records.Schema(i, schema_text(kind).encode(), "ros2msg", kind.replace("/", "/msg/")))
            for i, kind in enumerate(kinds, 1)
        ]
        self._channels = {
            i: _bytes(records.Channel(i, topic.name, "cdr", {}, kinds.index(topic.kind) + 1))
            for i, topic in enumerate(topics, main.channel)
        }
        text = text or json.dumps(header.to_dict(), sort_keys=True)
        self._metadata = records.Metadata(
            METADATA, {"format": version, "header": text, "header_crc32": f"{crc32(text.encode()):08x}"}
        )
        self._attachment = records.Attachment(0, 0, ATTACHMENT, "application/yaml", header.scenario_yaml.encode())
        # Of every ending: the first bytes, which do not depend on the chunks.
        self.ending_start = b"".join([DATA_END, *self._schemas, *self._channels.values()])
        metadata = _bytes(self._metadata)
        attachment = _bytes(self._attachment)
        # The metadata first, so that a reader finds it without looking for it.
        self.description = b"".join([OPENING, metadata, *self._schemas, *self._channels.values(), attachment])
        attachment_start = len(self.description) - len(attachment)
        self._metadata_index = records.MetadataIndex(len(OPENING), len(metadata), METADATA)
        self._attachment_index = records.AttachmentIndex(
            offset=attachment_start,
            length=len(attachment),
            log_time=0,
            create_time=0,
            data_size=len(self._attachment.data),
            name=ATTACHMENT,
            media_type=self._attachment.media_type,
        )

    def records(self, chunk: bytes, *, tail: bool = False) -> bytes | memoryview:
        """Return the records of a chunk of the file, uncompressed, their checksum verified.

        Args:
            chunk: the whole chunk, without the indexes behind it.
            tail: whether it is a block that was not yet full.

        Raises ValueError where it is damaged or cut off.
        """
        if len(chunk) < self.head_length() or 9 + int.from_bytes(chunk[1:9], "little") != len(chunk):
            raise ValueError("cut off")
        *_, size, crc, _, _ = CHUNK_HEAD.unpack_from(chunk)
        records: bytes | memoryview = memoryview(chunk)
        if self.compressor is None or tail:
            records = memoryview(chunk)[CHUNK_HEAD.size :]
        elif size > PICTURE_ROWS * max(template.row.size for template in self.templates):
            raise ValueError("damaged")
        else:
            records = decompress(memoryview(chunk)[ZSTD_HEAD.size :], size)
        if len(records) != size or crc32(records) != crc:
            raise ValueError("damaged")
        return records

    def read_rows(self, records: bytes | memoryview, first: int, rows: Array) -> None:
        """Write the rows (n, width), C-contiguous, whose messages are `records`, the first of them sample `first`.

        Raises ValueError where the records are not those of these samples.
        """
        template, numbers = self.templates[0], first + self.every * np.arange(len(rows))
        if len(records) != len(rows) * template.row.size or (template.numbers(records) != numbers).any():
            raise ValueError("damaged")
        template.decode(records, rows)
        rows[:, self._time] = numbers * self.step

    @property
    def gap(self) -> int:
        """Bytes from the end of the last chunk to a block that is not yet full: room for that block once it is."""
        template = self.templates[0]
        indexes = len(template.group.topics) * template.index_length(BLOCK)
        return largest(BLOCK * template.row.size) + indexes

    def head_length(self) -> int:
        """Return how many bytes of a chunk's record stand before its compressed records."""
        return CHUNK_HEAD.size if self.compressor is None else ZSTD_HEAD.size

    def block(self, rows: Array, first: int) -> memoryview:
        """Return the chunk and the indexes of `rows`, the first of them sample `first`, uncompressed.

        They are valid until the next call.
        """
        if len(rows) < BLOCK:
            return Chunk(self.templates[0], len(rows), self.step).encode(rows, first)
        self._full_block = self._full_block or Chunk(self.templates[0], BLOCK, self.step)
        return self._full_block.encode(rows, first)

    def pictures(self, rows: Array, first: int) -> list[Piece]:
        """Return the chunks that show `rows`, the first of them sample `first`."""
        pieces = []
        for i, template in enumerate(self.templates[1:], 1):
            every, source = template.group.every, template.group.source
            begin = -(-first // every) * every
            chosen = rows[(begin - first) // self.every :: every // self.every]
            if len(chosen):
                raw = Chunk(template, len(chosen), self.step).encode(source(chosen), begin)
                pieces.append(Piece(i, begin, len(chosen), raw))
        return pieces

    def stored(self, piece: Piece, start: int) -> tuple[bytes | memoryview, Written]:
        """Return a chunk and its indexes as the file holds them, at byte `start`."""
        data: bytes | memoryview = piece.raw
        if self.compressor is None:
            size = piece.n * self.templates[piece.group].row.size
        else:
            data, size = self.compressor.compress(piece.raw)
        return data, Written(piece.group, piece.first, piece.n, start, size)

    def length(self, written: Written) -> int:
        """Return how many bytes a chunk takes, its indexes included."""
        return self.indexes[written.group].length(written.n, written.size)

    def ending(self, chunks: list[Written], last: int, start: int) -> bytes:
        """Return all that follows the last chunk, to stand at byte `start`; `last` is the last sample."""
        counts = dict.fromkeys(self._channels, 0)
        for i, template in enumerate(self.templates):
            n = sum(chunk.n for chunk in chunks if chunk.group == i)
            counts.update((template.group.channel + j, n) for j in range(len(template.group.topics)))
        statistics = records.Statistics(
            attachment_count=1,
            channel_count=len(self._channels),
            channel_message_counts=counts,
            chunk_count=len(chunks),
            message_count=sum(counts.values()),
            message_end_time=self._nanoseconds(max(last, 0)),
            message_start_time=0,
            metadata_count=1,
            schema_count=len(self._schemas),
        )
        parts = {
            Opcode.SCHEMA: self._schemas,
            Opcode.CHANNEL: self._channels.values(),
            Opcode.STATISTICS: [_bytes(statistics)],
            Opcode.CHUNK_INDEX: [chunk_indexes(self.indexes, chunks)],
            Opcode.ATTACHMENT_INDEX: [_bytes(self._attachment_index)],
            Opcode.METADATA_INDEX: [_bytes(self._metadata_index)],
        }
        summary, offsets = b"", b""
        summary_start = start + len(DATA_END)
        for opcode, group in parts.items():
            part = b"".join(group)
            if part:
                offsets += _bytes(records.SummaryOffset(opcode, summary_start + len(summary), len(part)))
            summary += part
        offsets_start = summary_start + len(summary)
        # The footer's checksum covers the summary and the footer up to itself.
        footer = struct.pack("<BQQQ", Opcode.FOOTER, 20, summary_start, offsets_start)
        footer += struct.pack("<I", crc32(summary + offsets + footer))
        return DATA_END + summary + offsets + footer + MAGIC

    def _nanoseconds(self, sample: int) -> int:
        return round(sample * self.step * 1e9)  # as `nanoseconds` does for many


def _bytes(record: records.McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


DATA_END = _bytes(records.DataEnd(0))
OPENING = MAGIC + _bytes(records.Header("ros2", "cdpr"))
