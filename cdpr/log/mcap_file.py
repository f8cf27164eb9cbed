"""Layout of the log file. Equal header and rows give equal bytes.

    description   MCAP header, metadata "cdpr" (the run's Header as JSON), schemas, channels, scenario.yaml
    blocks        256 rows each: one chunk with all messages of these rows, and its message indexes
    pictures      after every 16 blocks and at the end: chunks of /clock, /tf and /cdpr/markers for these rows
    ending        data end, summary, footer

Chunks are compressed by zstd. During a run, an incomplete block follows the last chunk at a distance of
`LogFormat.gap`, uncompressed and without indexes. The complete block is later written before it and never overwrites
it.

The description and the blocks suffice to restore the run; `FORMATS` counts changes to them.
Format 3 had no compression, and an incomplete block had the same position as the complete one.
Format 2 also had /clock in the blocks, and /cdpr/cable_commands even if equal to the efforts of /cdpr/cable_states.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass

import numpy as np
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode

from cdpr.log.blocks import BLOCK
from cdpr.log.checksum import crc32
from cdpr.log.chunk import CHUNK_HEAD, Chunk, Template
from cdpr.log.chunk_index import ChunkIndex, Written, chunk_indexes
from cdpr.log.compression import NAME, ZSTD_HEAD, Compressor, decompress, largest
from cdpr.log.header import Header
from cdpr.log.ros2 import schema_text
from cdpr.log.topics import run_topics
from cdpr.log.visuals import visual_topics
from cdpr.model.robot import Array

FORMATS = ("2", "3", "4")  # supported versions; the last one is written
UNCOMPRESSED = ("2", "3")
LOG_NAME = "log.mcap"  # in a run folder
MAGIC = b"\x89MCAP0\r\n"
PICTURE_ROWS = 16 * BLOCK  # rows of the run per group of picture chunks, which are rarely read
METADATA = "cdpr"
ATTACHMENT = "scenario.yaml"


@dataclass(frozen=True)
class Piece:
    """Chunk to be written."""

    group: int
    first: int
    n: int
    raw: memoryview  # uncompressed chunk and its message indexes


class LogFormat:
    """All bytes of a log that follow from its Header.

    Readers pass the header's `text`, possibly of an older version, and the format version.
    """

    def __init__(self, header: Header, text: str | None = None, version: str = FORMATS[-1]) -> None:
        repeated = version == "2"
        main = run_topics(header, repeated=repeated)
        groups = (main, *visual_topics(header, main.channel + len(main.topics), clock=not repeated))
        self.templates = tuple(Template(group) for group in groups)  # of the rows, then of the pictures
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
        # Start of every ending, independent of the chunks.
        self.ending_start = b"".join([DATA_END, *self._schemas, *self._channels.values()])
        metadata = _bytes(self._metadata)
        attachment = _bytes(self._attachment)
        # The metadata comes first, so that readers find it directly.
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
        """Return the uncompressed records of a chunk after verifying their checksum.

        Args:
            chunk: the whole chunk without its indexes.
            tail: True for an incomplete block.

        Raises:
            ValueError: if it is damaged or cut off.
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
        """Decode records into `rows` (n, width), C-contiguous, the first of them for sample `first`.

        Raises:
            ValueError: if the records do not belong to these samples.
        """
        template, numbers = self.templates[0], first + self.every * np.arange(len(rows))
        if len(records) != len(rows) * template.row.size or (template.numbers(records) != numbers).any():
            raise ValueError("damaged")
        template.decode(records, rows)
        rows[:, self._time] = numbers * self.step

    @property
    def gap(self) -> int:
        """Distance from the last chunk to an incomplete block, bytes: the space of that block once complete."""
        template = self.templates[0]
        indexes = len(template.group.topics) * template.index_length(BLOCK)
        return largest(BLOCK * template.row.size) + indexes

    def head_length(self) -> int:
        """Return the size of a chunk's record before its compressed records, bytes."""
        return CHUNK_HEAD.size if self.compressor is None else ZSTD_HEAD.size

    def block(self, rows: Array, first: int) -> memoryview:
        """Return the uncompressed chunk and indexes of `rows`, the first of them sample `first`.

        The result is valid until the next call.
        """
        if len(rows) < BLOCK:
            return Chunk(self.templates[0], len(rows), self.step).encode(rows, first)
        self._full_block = self._full_block or Chunk(self.templates[0], BLOCK, self.step)
        return self._full_block.encode(rows, first)

    def pictures(self, rows: Array, first: int) -> list[Piece]:
        """Return the picture chunks of `rows`, the first of them sample `first`."""
        pieces = []
        for i, template in enumerate(self.templates[1:], 1):
            every, source = template.group.every, template.group.source
            begin = -(-first // every) * every
            chosen = rows[(begin - first) // self.every :: every // self.every]
            if len(chosen):
                raw = Chunk(template, len(chosen), self.step).encode(source(chosen), begin)
                pieces.append(Piece(i, begin, len(chosen), raw))
        return pieces

    def stored(self, piece: Piece, start: int) -> tuple[list[bytes | memoryview], Written]:
        """Return a chunk and its indexes as stored in the file, at byte `start`, in parts.

        The result is valid until the next call.
        """
        parts: list[bytes | memoryview] = [piece.raw]
        template = self.templates[piece.group]
        if self.compressor is None:
            size = piece.n * template.row.size
        else:
            parts, size = self.compressor.compress(piece.raw, template)
        return parts, Written(piece.group, piece.first, piece.n, start, size)

    def length(self, written: Written) -> int:
        """Return the size of a chunk and its indexes, bytes."""
        return self.indexes[written.group].length(written.n, written.size)

    def ending(self, chunks: list[Written], last: int, start: int) -> bytes:
        """Return everything after the last chunk, for byte `start`; `last` is the last sample."""
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
        return round(sample * self.step * 1e9)  # same rounding as in `nanoseconds`


def _bytes(record: records.McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


DATA_END = _bytes(records.DataEnd(0))
OPENING = MAGIC + _bytes(records.Header("ros2", "cdpr"))
