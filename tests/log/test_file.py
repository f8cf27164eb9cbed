"""The log as others read it: mcap's own reader, mcap_ros2 and rosbags."""

from __future__ import annotations

import hashlib
import json
import math
import zlib
from dataclasses import replace
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from command_line import cdpr_here
from log_cases import make_header, make_rows, write_log
from log_topics import FULL_RATE, PICTURES, wxyz, xyz
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import Chunk, ChunkIndex, MessageIndex
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from cdpr.log.blocks import BLOCK
from cdpr.log.header import Header
from cdpr.log.mcap_file import PICTURE_ROWS, LogFormat
from cdpr.model.robot import Array

COMMANDS = {"/cdpr/cable_commands": "sensor_msgs/msg/JointState"}  # at full rate, too, where cables are not ideal


def values_of(topic: str, message: Any, header: Header) -> dict[str, list[float]]:
    """The fields of a row that a message holds."""
    prefix = "desired_" if topic.endswith("_desired") else ""
    match topic.removesuffix("_desired"):
        case "/cdpr/cable_states":
            tension = "tension" if header.ideal_cables else "cable_tension"
            joints = {"length": message.position, "rate": message.velocity, tension: message.effort}
            return {name: list(values) for name, values in joints.items()}
        case "/cdpr/cable_commands":
            assert len(message.position) == len(message.velocity) == 0
            return {"tension": list(message.effort)}
        case "/cdpr/platform/pose":
            pose = message.pose
            return {f"{prefix}position": xyz(pose.position), f"{prefix}orientation": wxyz(pose.orientation)}
        case "/cdpr/platform/twist":
            v, w = message.twist.linear, message.twist.angular
            return {f"{prefix}velocity": xyz(v), f"{prefix}angular_velocity": xyz(w)}
        case "/cdpr/platform/acceleration":
            v, w = message.accel.linear, message.accel.angular
            return {f"{prefix}acceleration": xyz(v), f"{prefix}angular_acceleration": xyz(w)}
        case "/cdpr/platform/wrench":
            return {"wrench": xyz(message.wrench.force) + xyz(message.wrench.torque)}
        case "/cdpr/platform/external_wrench":
            return {"external": xyz(message.wrench.force) + xyz(message.wrench.torque)}
        case "/cdpr/solver" | "/cdpr/energy":
            (dim,) = message.layout.dim
            assert (dim.size, dim.stride, message.layout.data_offset) == (4, 4, 0)
            names = dim.label.split(", ")
            return {name: [value] for name, value in zip(names, message.data, strict=True)}
    raise AssertionError(topic)


def check_message(topic: str, message: Any, time: int, header: Header, row: Array) -> set[str]:
    if hasattr(message, "header"):
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == time
        assert message.header.frame_id == "world"
    if hasattr(message, "name"):
        assert tuple(message.name) == header.cables
    values = values_of(topic, message, header)
    for name, value in values.items():
        assert value == row[header.layout.columns[name]].tolist()
    return set(values)


MORE_THAN_A_BLOCK = BLOCK + 30  # rows


@pytest.mark.parametrize(
    ("m", "model"),
    [
        (1, "ideal"),
        (3, "elastic"),
        pytest.param(3, "ideal", marks=pytest.mark.slow),
        (8, "ideal"),
        pytest.param(12, "ideal", marks=pytest.mark.slow),
    ],
)
@pytest.mark.usual("3-elastic")
def test_every_column_is_in_the_messages(tmp_path: Path, m: int, model: str) -> None:
    """Each number once, except the time, which the number of a message determines."""
    shape = {"sphere": 0.2} if m == 3 else None if m == 1 else {"box": [1.0, 2.0, 3.0]}
    header = make_header(m, shape=shape, cable_model=model)
    full_rate = FULL_RATE if header.ideal_cables else FULL_RATE | COMMANDS
    rows = make_rows(header, MORE_THAN_A_BLOCK)
    store = get_typestore(Stores.ROS2_JAZZY)
    seen: dict[int, list[str]] = {}
    with write_log(tmp_path / "log.mcap", header, rows).open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            assert schema is not None
            kind = (full_rate | PICTURES)[channel.topic]
            assert (schema.name, schema.encoding, channel.message_encoding) == (kind, "ros2msg", "cdr")
            k = message.sequence
            assert message.log_time == message.publish_time == round(k * header.control_step * 1e9)
            again = store.deserialize_cdr(message.data, kind)
            assert bytes(store.serialize_cdr(again, kind)) == message.data
            if channel.topic in full_rate:
                columns = check_message(channel.topic, decoded, message.log_time, header, rows[k])
                assert check_message(channel.topic, again, message.log_time, header, rows[k]) == columns
                seen.setdefault(k, []).extend(columns)
    assert sorted(seen) == list(range(MORE_THAN_A_BLOCK))
    assert all(sorted(["time", *columns]) == sorted(header.layout.columns) for columns in seen.values())


def test_rosbags_opens_the_file_itself(tmp_path: Path) -> None:
    header = make_header(3)
    path = write_log(tmp_path / "log.mcap", header, make_rows(header, 400))
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        assert {c.topic: c.msgtype for c in reader.connections} == FULL_RATE | PICTURES
        assert sum(1 for _ in reader.messages()) == reader.message_count == 400 * len(FULL_RATE) + 2 * 24 + 12


@pytest.mark.slow
def test_order_and_count(tmp_path: Path) -> None:
    header = make_header(2)
    k = PICTURE_ROWS + BLOCK + 10
    path = write_log(tmp_path / "log.mcap", header, make_rows(header, k))
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        listed = [(c.topic, m.sequence, m.log_time, m.data) for _, c, m in reader.iter_messages()]
        in_file = [(c.topic, m.sequence) for _, c, m in reader.iter_messages(log_time_order=False)]
        assert reader.get_header().profile == "ros2"
    assert summary is not None
    statistics = summary.statistics
    assert statistics is not None
    counts = {summary.channels[i].topic: n for i, n in statistics.channel_message_counts.items()}
    expected = dict.fromkeys(FULL_RATE, k) | {"/clock": -(-k // 17), "/tf": -(-k // 17), "/cdpr/markers": -(-k // 34)}
    assert counts == expected
    assert {topic: sum(t == topic for t, *_ in listed) for topic in expected} == expected
    assert statistics.message_count == len(listed) == len(in_file)
    assert (statistics.message_start_time, statistics.message_end_time) == (0, (k - 1) * 1_000_000)
    assert (statistics.schema_count, statistics.channel_count) == (9, len(FULL_RATE | PICTURES))
    assert (statistics.attachment_count, statistics.metadata_count) == (1, 1)
    assert statistics.chunk_count == len(summary.chunk_indexes) == 18 + 2 * 2
    assert all(a[2] <= b[2] for a, b in pairwise(listed))
    rows_order = [(topic, number) for topic, number in in_file if topic in FULL_RATE]
    assert rows_order == [(topic, i) for i in range(k) for topic in FULL_RATE]
    with path.open("rb") as file:
        streamed = [(c.topic, m.sequence, m.log_time, m.data) for _, c, m in NonSeekingReader(file).iter_messages()]
    assert sorted(streamed) == sorted(listed)
    with path.open("rb") as file:
        part = [
            m.sequence
            for _, _, m in make_reader(file).iter_messages(
                ["/cdpr/platform/wrench"], starting_at=300_000_000, ending_at=4_100_000_000
            )
        ]
    assert part == list(range(300, 4101))


def test_indexes_and_checksums(tmp_path: Path) -> None:
    header = make_header(3)
    path = write_log(tmp_path / "log.mcap", header, make_rows(header, 2 * BLOCK + 7))
    data = path.read_bytes()
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    for index in summary.chunk_indexes:
        chunk = read_record(data, index.chunk_start_offset, Chunk)
        assert index.chunk_length == 9 + int.from_bytes(data[index.chunk_start_offset + 1 :][:8], "little")
        assert (chunk.message_start_time, chunk.message_end_time) == times_of(index)
        records = zstandard.decompress(chunk.data)
        assert (chunk.compression, chunk.uncompressed_size) == ("zstd", len(records))
        assert (index.compression, index.uncompressed_size, index.compressed_size) == (
            "zstd",
            len(records),
            len(chunk.data),
        )
        assert chunk.uncompressed_crc == zlib.crc32(records) != 0
        messages = breakup_chunk(chunk, validate_crc=True)
        times = [message.log_time for message in messages]
        assert (min(times), max(times)) == times_of(index)
        length = 0
        for channel, offset in index.message_index_offsets.items():
            entries = read_record(data, offset, MessageIndex)
            assert entries.channel_id == channel
            mine = [message for message in messages if message.channel_id == channel]
            assert [time for time, _ in entries.records] == [message.log_time for message in mine]
            for (_, place), message in zip(entries.records, mine, strict=True):
                assert records[place] == 5
                size = int.from_bytes(records[place + 1 : place + 9], "little")
                assert records[place + 31 : place + 9 + size] == message.data
            length += 9 + 6 + 16 * len(mine)
        assert length == index.message_index_length
        assert min(index.message_index_offsets.values()) == index.chunk_start_offset + index.chunk_length


def times_of(index: ChunkIndex) -> tuple[int, int]:
    return index.message_start_time, index.message_end_time


def read_record(data: bytes, offset: int, kind: type) -> Any:
    record = next(StreamReader(BytesIO(data[offset:]), skip_magic=True, emit_chunks=True).records)
    assert isinstance(record, kind)
    return record


def test_the_file_explains_itself(tmp_path: Path) -> None:
    header = make_header(4)
    path = write_log(tmp_path / "log.mcap", header, make_rows(header, 3))
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        (attachment,) = reader.iter_attachments()
        (metadata,) = reader.iter_metadata()
    assert (attachment.name, attachment.media_type) == ("scenario.yaml", "application/yaml")
    assert (attachment.log_time, attachment.create_time) == (0, 0)
    assert attachment.data.decode() == header.scenario_yaml
    assert metadata.name == "cdpr"
    assert Header.from_dict(json.loads(metadata.metadata["header"])) == header


@pytest.mark.parametrize("step", [1 / 3000, 0.01, 1 / 60, 0.1])
def test_other_steps(tmp_path: Path, step: float) -> None:
    header = make_header(2, control_step=step)
    rows = make_rows(header, 301)
    times: dict[str, list[int]] = {}
    with write_log(tmp_path / "log.mcap", header, rows).open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            times.setdefault(channel.topic, []).append(message.log_time)
    assert times["/cdpr/energy"] == [round(k * step * 1e9) for k in range(301)]
    assert times["/clock"] == times["/tf"]
    for topic, rate in (("/tf", 60), ("/cdpr/markers", 30)):
        gaps = np.diff(times[topic])
        assert min(gaps) >= max(1e9 / rate, step * 1e9) - 2


def test_no_rows(tmp_path: Path) -> None:
    header = make_header(2)
    path = write_log(tmp_path / "log.mcap", header, make_rows(header, 0))
    with path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert list(reader.iter_messages()) == []
    assert summary is not None
    assert len(summary.channels) == len(FULL_RATE | PICTURES)


@pytest.mark.parametrize(
    ("version", "known"), [("2", "995fcaed47b3c5d5"), ("3", "609718e0e5d7f32e"), ("4", "1ee3427f417634f0")]
)
def test_formats_are_frozen(version: str, known: str) -> None:
    """If this fails, old logs can no longer be read: add to FORMATS, and its hash here.

    Of what is compressed, the hash is of the uncompressed bytes: the others are the library's.
    """
    header = make_header(2)
    form = LogFormat(header, "{}", version)
    rows = np.arange(3.0 * header.layout.width).reshape(3, -1) / 8.0
    digest = hashlib.sha256(form.description + bytes(form.block(rows, 300))).hexdigest()
    assert digest[:16] == known


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"anchors": ((math.nan,) * 6,) * 2}, "anchors: expected 2 x 6 finite numbers"),
        ({"anchors": ((0.0,) * 6,)}, "anchors: expected 2 x 6 finite numbers"),
        ({"path": ((0.0, math.inf, 0.0),)}, "path: expected 1 x 3 finite numbers"),
        ({"frame": ((math.nan,) * 6,)}, "frame: expected 1 x 6 finite numbers"),
        ({"shape": {"box": [1.0, math.nan, 1.0]}}, "shape: expected 3 finite numbers"),
        ({"tension_max": (math.nan, 1.0)}, "tension_max: expected 2 finite numbers"),
        ({"scenario": 7}, "scenario: expected a text"),
        ({"cables": (None, None)}, "cables: expected texts"),
        ({"bounds": ((1.0,),)}, "bounds: expected 3 x 2 finite numbers"),
        ({"bounds": ((None, 1.0), (2.0, math.nan), (None, None))}, "bounds: expected 3 x 2 finite numbers"),
        ({"broken": ((-1, 0.5),)}, "broken: expected cables from 0 to 1"),
        ({"mass": -1.0}, "characteristic_length, mass and steps, above 0: expected 4 finite numbers"),
    ],
)
def test_a_header_that_others_made_up_is_one_error(wrong, told, tmp_path):
    """Its checksum is right, so that it was not damaged; nothing can be drawn of it."""
    good = make_header(2)
    log = write_log(tmp_path / "log.mcap", replace(good, **wrong), make_rows(good, 3))
    done = cdpr_here("view", log, "--no-open", "--out", tmp_path / "page.html", cwd=tmp_path, code=2)
    assert f"{log}: its header is not one that cdpr writes: {told}" in done.stderr
    assert "internal error" not in done.stderr
