"""Torn, flipped, foreign and empty logs: a valid prefix or one clear error, never a wrong row."""

from __future__ import annotations

import json
import os
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from log_cases import make_header, make_rows, same_bits, write_log
from mcap.reader import make_reader
from mcap.writer import Writer

from cdpr.base.errors import LogError, OutputError
from cdpr.log.blocks import BLOCK
from cdpr.log.mcap_file import FORMATS, LogFormat
from cdpr.log.reader import load_run, scan
from cdpr.log.recorder import Recorder
from cdpr.log.repair import repair
from cdpr.log.run import Run
from cdpr.log.run_folder import RunFolder

HEADER = make_header(2)
ROWS = make_rows(HEADER, 2 * BLOCK + 44)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return write_log(tmp_path_factory.mktemp("whole") / "log.mcap", HEADER, ROWS).read_bytes()


@pytest.fixture(scope="module")
def blocks(whole: bytes, tmp_path_factory: pytest.TempPathFactory) -> list[tuple[int, int, int]]:
    """Of each block of `whole`: where its chunk begins, where that ends, and where its indexes do."""
    path = tmp_path_factory.mktemp("blocks") / "log.mcap"
    path.write_bytes(whole)
    found = scan(path)
    return [
        (chunk.start, chunk.start + found.form.head_length() + chunk.size, chunk.start + found.form.length(chunk))
        for chunk in found.chunks
        if chunk.group == 0
    ]


def check(path: Path, data: bytes) -> str | None:
    """Load `data`; the rows are a prefix of the truth. Return the problem reported by the reader."""
    path.write_bytes(data)
    try:
        found = scan(path)
    except LogError as error:
        text = str(error)
        return text if text.startswith(f"{path}: ") and "\n" not in text else pytest.fail(text)
    assert found.header == HEADER
    assert same_bits(found.rows, ROWS[: len(found.rows)])
    if found.problem is None:
        assert len(found.rows) == len(ROWS)
    return found.problem


def truncations(data: bytes, blocks: list[tuple[int, int, int]], every: int) -> list[int]:
    """Lengths: the last 4 KiB, and 4 KiB about the end of each block."""
    ends = [len(data)]
    for _, stop, end in blocks:
        ends += [stop, stop + 2048, end + 100]
    return sorted({length for end in ends for length in range(end - 4096, min(end, len(data)), every)})


@pytest.mark.slow
def test_truncated(tmp_path: Path, whole: bytes, blocks: list[tuple[int, int, int]]) -> None:
    for length in truncations(whole, blocks, 397):
        assert check(tmp_path / "log.mcap", whole[:length]) is not None


@pytest.mark.slow
def test_truncated_at_thousands_of_bytes(tmp_path: Path, whole: bytes, blocks: list[tuple[int, int, int]]) -> None:
    for length in truncations(whole, blocks, 29):
        assert check(tmp_path / "log.mcap", whole[:length]) is not None


def test_truncated_in_the_description(tmp_path: Path, whole: bytes) -> None:
    for length in range(0, 9000, 61):
        check(tmp_path / "log.mcap", whole[:length])


def test_repair_cuts_only_the_torn_block(tmp_path: Path, whole: bytes, blocks: list[tuple[int, int, int]]) -> None:
    _, stop, _ = blocks[0]
    for cut, rows in ((stop - 1, 0), (stop, BLOCK), (stop + 1, BLOCK)):
        (tmp_path / "log.mcap").write_bytes(whole[:cut])
        assert len(scan(tmp_path / "log.mcap").rows) == rows


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_flipped_bits(tmp_path: Path, whole: bytes, seed: int) -> None:
    rng = np.random.default_rng(seed)
    form = LogFormat(HEADER)
    places = [
        *rng.integers(0, len(whole), 100),
        *rng.integers(0, len(form.description), 50),
        *rng.integers(len(whole) - 9000, len(whole), 50),
    ]
    harmless = 0
    for place in places:
        data = bytearray(whole)
        data[place] ^= 1 << int(rng.integers(8))
        harmless += check(tmp_path / "log.mcap", bytes(data)) is None
    assert harmless < 10  # only the message indexes of the pictures are not read


@pytest.mark.slow
def test_flipped_bit_in_every_part_of_a_block(tmp_path: Path, whole: bytes, blocks: list[tuple[int, int, int]]) -> None:
    start, stop, end = blocks[0]
    unused = start + LogFormat(HEADER).head_length() + 4  # of the frame's descriptor zstd ignores bit 4 (RFC 8878)
    for place in (*range(start, start + 300), *range(start, stop, 199), *range(stop, end, 999)):
        data = bytearray(whole)
        data[place] ^= 0x10 if place != unused else 0x08
        assert check(tmp_path / "log.mcap", bytes(data)) is not None
        assert len(scan(tmp_path / "log.mcap").rows) == (BLOCK if place >= stop else 0)


def test_bytes_with_a_new_checksum_are_not_believed(
    tmp_path: Path, whole: bytes, blocks: list[tuple[int, int, int]]
) -> None:
    """A block out of place has a right checksum and wrong numbers."""
    (start, _, second), (_, _, third) = blocks[:2]
    swapped = whole[:start] + whole[second:third] + whole[start:second]
    assert check(tmp_path / "log.mcap", swapped + whole[third:]) is not None
    assert len(scan(tmp_path / "log.mcap").rows) == 0
    skipped = whole[:second] + whole[third:]
    assert check(tmp_path / "log.mcap", skipped) is not None
    doubled = whole[:third] + whole[second:]
    assert check(tmp_path / "log.mcap", doubled) is not None


def test_rubbish_behind_a_complete_log_is_reported(tmp_path: Path, whole: bytes) -> None:
    assert check(tmp_path / "log.mcap", whole + b"x") is not None
    assert len(scan(tmp_path / "log.mcap").rows) == len(ROWS)


def test_not_our_log(tmp_path: Path) -> None:
    foreign = tmp_path / "foreign.mcap"
    with foreign.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2", "someone")
        schema = writer.register_schema("x", "ros2msg", b"int32 x")
        channel = writer.register_channel("/x", "cdr", schema)
        writer.add_message(channel, 0, b"\0\1\0\0\0\0\0\0", 0)
        writer.finish()
    with pytest.raises(LogError, match=r"foreign\.mcap: is an MCAP file, but no log of cdpr"):
        load_run(foreign)
    text = tmp_path / "a.mcap"
    text.write_text("robot: caroca\n")
    with pytest.raises(LogError, match="is not an MCAP file"):
        load_run(text)
    (tmp_path / "log.mcap").write_bytes(b"")
    with pytest.raises(LogError, match="is empty"):
        load_run(tmp_path)
    with pytest.raises(LogError, match="is empty"):
        repair(tmp_path)
    with pytest.raises(LogError, match=r"nothing: no such file or folder"):
        load_run(tmp_path / "nothing")
    (tmp_path / "empty").mkdir()
    with pytest.raises(LogError, match=r"empty: contains no log\.mcap"):
        load_run(tmp_path / "empty")


def test_a_log_of_another_format_is_reported(tmp_path: Path, whole: bytes) -> None:
    path = tmp_path / "log.mcap"
    written = b"format\x01\0\0\x00"
    path.write_bytes(whole.replace(written + FORMATS[-1].encode(), written + b"9", 1))
    with pytest.raises(LogError, match="has log format 9, this cdpr reads 2, 3 and 4: use the version that wrote it"):
        load_run(path)


def test_a_header_with_fields_of_a_later_version_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    to_dict = type(HEADER).to_dict
    with monkeypatch.context() as later:
        later.setattr(type(HEADER), "to_dict", lambda self: {**to_dict(self), "colour": "red"})
        path = write_log(tmp_path / "log.mcap", HEADER, ROWS)
    with pytest.raises(LogError, match="another version of cdpr"):
        load_run(path)


@pytest.mark.parametrize("wrong", [{"control_step": 0.0}, {"log_every": 0}, {"frame": 3}], ids=str)
def test_a_header_that_makes_no_sense_is_refused(tmp_path: Path, wrong: dict[str, object]) -> None:
    path = tmp_path / "log.mcap"
    path.write_bytes(LogFormat(HEADER, json.dumps(HEADER.to_dict() | wrong)).description)
    with pytest.raises(LogError, match="another version of cdpr"):
        load_run(path)


@pytest.mark.parametrize("cut", [-1, -9000, -120_000, 9000])
def test_repair(tmp_path: Path, whole: bytes, cut: int) -> None:
    folder = RunFolder(tmp_path / "run", HEADER, ["cdpr", "run"]).path
    log = folder / "log.mcap"
    log.write_bytes(whole[:cut])
    kept = len(scan(log).rows)
    report = repair(folder)
    assert (report.rows, report.interrupted, report.changed) == (kept, True, True)
    assert report.problem is not None
    assert report.torn is not None
    rest = report.torn.read_bytes()
    assert whole[:cut].endswith(rest)
    assert log.read_bytes().startswith(whole[: len(whole[:cut]) - len(rest)])  # all that is not in the log is there
    assert sorted(path.name for path in folder.iterdir()) == [
        "log.mcap",
        "log.mcap.torn",
        "run.json",
        "scenario.yaml",
    ]
    with log.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert len(list(reader.iter_messages(["/cdpr/energy"]))) == kept
    run = load_run(folder)  # without a warning
    assert (run.status, run.message) == ("interrupted", f"killed while it ran; {kept} rows kept")
    assert same_bits(run.rows, ROWS[:kept])
    assert log.read_bytes() == write_log(tmp_path / "again.mcap", HEADER, ROWS[:kept]).read_bytes()
    before = {path: path.read_bytes() for path in folder.iterdir()}
    report = repair(folder)
    assert (report.problem, report.changed, report.rows) == (None, False, kept)
    assert {path: path.read_bytes() for path in folder.iterdir()} == before
    content = json.loads((folder / "run.json").read_text())
    assert content["argv"] == ["cdpr", "run"]
    assert content["summary"]["samples"] == kept


@pytest.mark.parametrize("zeros", [1, 9, 100, 1_000_000])
def test_zeros_behind_the_last_block_are_no_rows(tmp_path: Path, whole: bytes, zeros: int) -> None:
    """As a file system may leave where the power failed."""
    path = tmp_path / "a.mcap"
    path.write_bytes(whole)
    found = scan(path)
    path.write_bytes(whole[: found.end] + bytes(zeros))
    torn = scan(path)
    assert torn.problem is not None
    assert same_bits(torn.rows, ROWS)
    repair(path)
    assert path.read_bytes() == whole


def test_repair_of_a_log_alone_and_twice(tmp_path: Path, whole: bytes) -> None:
    path = tmp_path / "a.mcap"
    for number in ("", "-2"):
        path.write_bytes(whole[:-5])
        report = repair(path)
        assert report.torn == tmp_path / f"a.mcap.torn{number}"
        assert not report.interrupted
        assert path.read_bytes() == whole


@pytest.mark.slow
def test_every_cut_is_mended_to_the_bytes_of_a_whole_log(tmp_path: Path, whole: bytes) -> None:
    path = tmp_path / "a.mcap"
    description = len(LogFormat(HEADER).description)
    found: dict[int, bytes] = {}
    for cut in np.random.default_rng(1).integers(description, len(whole), 40):
        path.write_bytes(whole[:cut])
        rows = repair(path).rows
        found.setdefault(rows, write_log(tmp_path / "again.mcap", HEADER, ROWS[:rows]).read_bytes())
        assert path.read_bytes() == found[rows]
    assert len(found) > 2


def test_a_damaged_description_is_mended_in_its_place(tmp_path: Path, whole: bytes) -> None:
    path = tmp_path / "a.mcap"
    damaged = bytearray(whole)
    damaged[len(LogFormat(HEADER).description) - 100] ^= 1
    path.write_bytes(damaged)
    report = repair(path)
    assert (path.read_bytes(), report.rows) == (whole, len(ROWS))
    assert report.torn is not None
    assert damaged.startswith(report.torn.read_bytes()[: len(LogFormat(HEADER).description)])


def test_a_complete_log_of_a_killed_run(tmp_path: Path, whole: bytes) -> None:
    folder = RunFolder(tmp_path / "run", HEADER).path
    (folder / "log.mcap").write_bytes(whole)
    run = load_run(folder)
    assert run.status == "running"  # killed between the log's end and its own
    report = repair(folder)
    assert (report.problem, report.torn, report.interrupted) == (None, None, True)
    assert load_run(folder).status == "interrupted"


@pytest.mark.parametrize("size", [None, 0, 5, 3000])
def test_a_run_that_was_killed_before_its_log_held_anything(tmp_path: Path, whole: bytes, size: int | None) -> None:
    folder = RunFolder(tmp_path / "run", HEADER, ["cdpr", "run"]).path
    assert size is None or size < len(LogFormat(HEADER).description)
    if size is not None:
        (folder / "log.mcap").write_bytes(whole[:size])
    report = repair(folder)
    assert (report.rows, report.interrupted) == (0, True)
    content = json.loads((folder / "run.json").read_text())
    assert (content["status"], content["summary"]["status"]) == ("interrupted", "interrupted")
    assert (content["message"], content["argv"]) == ("killed before the first sample", ["cdpr", "run"])
    assert sorted(os.listdir(folder)) == ["run.json", "scenario.yaml"]


def test_a_damaged_header_is_not_taken_for_a_run_that_never_began(tmp_path: Path, whole: bytes) -> None:
    folder = RunFolder(tmp_path / "run", HEADER).path
    damaged = bytearray(whole)
    damaged[200] ^= 1
    (folder / "log.mcap").write_bytes(damaged)
    with pytest.raises(LogError, match="header is damaged"):
        repair(folder)
    assert (folder / "log.mcap").read_bytes() == damaged


def test_a_damage_in_the_middle_keeps_all_that_follows(tmp_path: Path, whole: bytes) -> None:
    path = tmp_path / "a.mcap"
    damaged = bytearray(whole)
    damaged[len(whole) // 2] ^= 1
    path.write_bytes(damaged)
    report = repair(path)
    assert report.torn is not None
    rest = report.torn.read_bytes()
    assert damaged.endswith(rest)
    assert len(rest) >= len(whole) // 2


def test_a_run_json_that_is_not_ours(tmp_path: Path, whole: bytes) -> None:
    (tmp_path / "log.mcap").write_bytes(whole)
    for text in ("{", "[]", "{}", '{"status": "finished", "events": [{"x": 1}]}', "\xff"):
        (tmp_path / "run.json").write_text(text, encoding="latin-1")
        with pytest.raises(LogError, match=r"run\.json: .*without that file the log still loads"):
            load_run(tmp_path)
    os.remove(tmp_path / "run.json")
    assert load_run(tmp_path).status == "finished"


def test_an_active_run_is_not_repaired(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "run", HEADER)
    recorder = Recorder(HEADER, len(ROWS), folder.path)
    recorder.rows[:-1] = ROWS
    recorder.flush(300)
    for path in (folder.path, folder.path / "log.mcap"):
        with pytest.raises(OutputError, match="its run, or a repair of it, is still going on"):
            repair(path)
    recorder.close(len(ROWS))
    folder.finish(Run(HEADER, ROWS))
    assert not repair(folder.path).changed


def test_repair_of_a_log_that_is_written_loses_nothing(tmp_path: Path, whole: bytes) -> None:
    """On a file system without locks, the next data of the writer is in its usual place."""
    recorder = Recorder(HEADER, len(ROWS), tmp_path)
    recorder.rows[:-1] = ROWS
    for rows in (300, 400):
        recorder.flush(rows)
        assert repair(tmp_path).rows == rows
    recorder.close(len(ROWS))
    assert (tmp_path / "log.mcap").read_bytes() == whole


def test_reading_is_quick_to_refuse_an_absurd_length(tmp_path: Path, whole: bytes) -> None:
    start = len(LogFormat(HEADER).description)
    data = bytearray(whole)
    data[start + 8] = 0x7F  # the length of the first chunk: 9e18 bytes
    tracemalloc.start()
    try:
        assert check(tmp_path / "log.mcap", bytes(data)) is not None
        assert tracemalloc.get_traced_memory()[1] < 20 * len(data)  # nothing is made ready for what is not there
    finally:
        tracemalloc.stop()
