"""Disks that are full, limited or read-only: an OutputError at once, and nothing that claims success."""

from __future__ import annotations

import collections
import errno
import itertools
import json
import os
import re
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT
from log_cases import make_header, make_rows, same_bits, write_log

from cdpr.base.errors import ExitCode, OutputError
from cdpr.log import recorder as recorder_module
from cdpr.log import run_json
from cdpr.log.blocks import BLOCK
from cdpr.log.chunk_file import QUEUE
from cdpr.log.event import Event
from cdpr.log.export import export
from cdpr.log.reader import load_run, scan
from cdpr.log.recorder import Recorder
from cdpr.log.repair import repair
from cdpr.log.rows import LogRows
from cdpr.log.run import Run
from cdpr.log.run_folder import RunFolder
from cdpr.log.writer import LogWriter

HEADER = make_header(2)
ROWS = make_rows(HEADER, 5 * BLOCK)


def test_dev_full_at_the_first_byte() -> None:
    with pytest.raises(OutputError, match="/dev/full: cannot be written: No space left on device") as caught:
        LogWriter(Path("/dev/full"), HEADER)
    assert caught.value.exit_code == ExitCode.NOT_WRITABLE == 8


def test_dev_full_at_the_first_block(tmp_path: Path) -> None:
    recorder = Recorder(HEADER, len(ROWS), tmp_path)
    recorder.rows[:-1] = ROWS
    assert recorder._writer is not None
    full = os.open("/dev/full", os.O_WRONLY)
    os.dup2(full, recorder._writer.out.file.fileno())
    os.close(full)
    with pytest.raises(OutputError, match=r"log\.mcap: cannot be written: No space left on device"):
        collections.deque(map(recorder.flush, range(BLOCK, (QUEUE + 3) * BLOCK, BLOCK)))  # a thread writes meanwhile
    for again in (recorder.flush, recorder.close):
        with pytest.raises(OutputError, match="No space left"):
            again(len(ROWS))
    assert same_bits(recorder.rows[:-1], ROWS)


@pytest.mark.parametrize("every", [1, 3])
@pytest.mark.parametrize("at", [0, 1, 19])
def test_a_full_disk_loses_no_row_of_a_run_on_disk(tmp_path: Path, every: int, at: int) -> None:
    """The blocks in the log are read there, what follows them was in memory only."""
    header = make_header(2, log_every=every)
    rows = make_rows(header, (20 * BLOCK + 77) * every + 2)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder_module, "IN_MEMORY", 0)
        recorder = Recorder(header, len(rows) - 1, tmp_path)
    done, failed = 0, False
    while done < len(rows) and not failed:
        first, done = done, min(done + BLOCK, len(rows))
        recorder.rows[first % len(recorder.rows) :][: done - first] = rows[first:done]
        room = (tmp_path / "log.mcap").stat().st_size + (1000 if done // BLOCK > at else 2**20)
        try:
            with file_size_limit(room):
                recorder.flush(done)
        except OutputError:
            failed = True
    assert failed
    with pytest.raises(OutputError, match="File too large"):
        recorder.close(done)
    expected = rows[:done:every]
    if (done - 1) % every:
        expected = np.concatenate([expected, rows[done - 1 : done]])
    for _ in range(2):
        assert isinstance(recorder.kept, LogRows)
        assert same_bits(np.array(recorder.kept), np.ascontiguousarray(expected))
    assert len(recorder.status) == done


@contextmanager
def file_size_limit(size: int) -> Iterator[None]:
    """Only around the call under test: pytest's own output may go to a larger file."""
    old = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, old[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old)


@pytest.mark.parametrize("blocks", [0, 1, 2])
def test_file_size_limit_within_a_block(tmp_path: Path, blocks: int) -> None:
    size = write_log(tmp_path / "whole.mcap", HEADER, ROWS).stat().st_size
    recorder = Recorder(HEADER, len(ROWS), tmp_path)
    recorder.rows[:-1] = ROWS
    limit = int(size * (blocks + 0.5) / 5.2)
    with pytest.raises(OutputError, match="File too large"), file_size_limit(limit):
        recorder.close(len(ROWS))
    found = scan(tmp_path / "log.mcap")
    assert found.problem is not None
    assert same_bits(found.rows, ROWS[: blocks * BLOCK])


def test_file_size_limit_within_the_ending(tmp_path: Path) -> None:
    size = write_log(tmp_path / "whole.mcap", HEADER, ROWS).stat().st_size
    recorder = Recorder(HEADER, len(ROWS), tmp_path)
    recorder.rows[:-1] = ROWS
    with pytest.raises(OutputError, match="File too large"), file_size_limit(size - 1):
        recorder.close(len(ROWS))
    assert len(scan(tmp_path / "log.mcap").rows) == len(ROWS)


def test_a_close_that_fails(tmp_path: Path) -> None:
    recorder = Recorder(HEADER, len(ROWS), tmp_path)
    recorder.rows[:-1] = ROWS
    assert recorder._writer is not None

    class Failing:
        """A file whose last error comes only when it is closed, as on a network disk."""

        closed = False

        def __init__(self, file: Any) -> None:
            self.seek, self.write, self.truncate, self._close = file.seek, file.write, file.truncate, file.close

        def close(self) -> None:
            self._close()
            raise OSError(errno.EDQUOT, "Disk quota exceeded")

    recorder._writer.out.file = Failing(recorder._writer.out.file)  # type: ignore[assignment]
    with pytest.raises(OutputError, match="Disk quota exceeded"):
        recorder.close(len(ROWS))


@pytest.mark.parametrize("at", [0, 2])
def test_a_block_that_cannot_be_made_leaves_no_gap(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, at: int) -> None:
    recorder = Recorder(HEADER, len(ROWS), tmp_path)
    recorder.rows[:-1] = ROWS
    assert recorder._writer is not None
    compressor = recorder._writer._format.compressor
    assert compressor is not None
    compress, calls = compressor.compress, itertools.count()

    def failing(*chunk: Any) -> tuple[list[bytes | memoryview], int]:
        if next(calls) == at:
            raise MemoryError
        return compress(*chunk)

    monkeypatch.setattr(compressor, "compress", failing)
    for _ in range(2):
        with pytest.raises(OutputError, match=r"log\.mcap: cannot be written: MemoryError"):
            recorder.close(len(ROWS))
    assert same_bits(np.asarray(scan(tmp_path / "log.mcap").rows), ROWS[: at * BLOCK])


@pytest.mark.parametrize("blocks", [0, 2, 5])
def test_without_a_thread_the_log_is_complete(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, blocks: int) -> None:
    """While the interpreter exits, as in a function of atexit, no thread can be started."""
    recorder = Recorder(HEADER, len(ROWS), tmp_path)
    recorder.rows[:-1] = ROWS
    assert recorder._writer is not None
    recorder.flush(blocks * BLOCK)

    def refuse(*_: Any) -> None:
        raise RuntimeError("cannot schedule new futures after interpreter shutdown")

    monkeypatch.setattr(recorder._writer.out._thread, "submit", refuse)
    recorder.close(len(ROWS))
    found = scan(tmp_path / "log.mcap")
    assert found.problem is None
    assert same_bits(np.asarray(found.rows), ROWS)


def test_a_folder_that_is_gone_or_a_file(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"log\.mcap: cannot be written: No such file or directory"):
        Recorder(HEADER, 3, tmp_path / "gone")
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="is a file, not a folder"):
        RunFolder(tmp_path / "file", HEADER)
    with pytest.raises(OutputError, match="Not a directory"):
        RunFolder(tmp_path / "file" / "run", HEADER)


def test_run_json_keeps_its_old_content_when_the_disk_is_full(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "run", HEADER)
    before = (folder.path / "run.json").read_bytes()
    with pytest.raises(OutputError, match=r"run\.json: cannot be written: File too large"), file_size_limit(100):
        folder.finish(Run(HEADER, ROWS))
    assert (folder.path / "run.json").read_bytes() == before
    assert json.loads(before)["status"] == "running"
    assert sorted(os.listdir(folder.path)) == ["run.json", "scenario.yaml"]


def test_repair_without_room_loses_no_row(tmp_path: Path) -> None:
    log = tmp_path / "log.mcap"
    whole = write_log(log, HEADER, ROWS).read_bytes()
    log.write_bytes(whole[:-1])
    with pytest.raises(OutputError, match="File too large"), file_size_limit(len(whole) // 2):
        repair(tmp_path)
    assert sorted(os.listdir(tmp_path)) == ["log.mcap", "log.mcap.torn"]
    assert same_bits(scan(log).rows, ROWS)
    repair(tmp_path)
    assert log.read_bytes() == whole


def test_repair_on_a_full_disk_needs_no_second_copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = tmp_path / "log.mcap"
    whole = write_log(log, HEADER, ROWS).read_bytes()
    log.write_bytes(whole[:-1])
    opened = Path.open

    def full(self: Path, mode: str = "r", *args: Any, **kwargs: Any) -> Any:
        if "w" in mode or "x" in mode:  # no new file
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return opened(self, mode, *args, **kwargs)

    monkeypatch.setattr(Path, "open", full)
    report = repair(tmp_path)
    assert (report.torn, os.listdir(tmp_path)) == (None, ["log.mcap"])
    assert report.lost > 0
    assert log.read_bytes() == whole


def test_a_full_disk_still_records_the_status(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = RunFolder(tmp_path / "run", HEADER)
    room = (folder.path / "run.json.new").stat()
    assert room.st_blocks * 512 >= room.st_size > 65536
    write = os.pwrite

    def full(file: int, data: bytes, place: int) -> int:
        if place + len(data) > room.st_size:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(file, data, place)

    monkeypatch.setattr(os, "pwrite", full)
    many = tuple(Event(0.1 * k, "at limit", "x" * 100) for k in range(1000))  # more than there is room for
    with pytest.raises(OutputError, match=r"run\.json: cannot be written: No space left"):
        folder.finish(Run(HEADER, ROWS, "failed", "log.mcap: cannot be written", many))
    content = json.loads((folder.path / "run.json").read_text())
    assert (content["status"], content["message"], content["events"]) == ("failed", "log.mcap: cannot be written", [])
    assert content["summary"]["samples"] == len(ROWS)
    assert sorted(os.listdir(folder.path)) == ["run.json", "scenario.yaml"]


def test_a_run_that_cannot_begin_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for out in (None, tmp_path / "run"):
        with pytest.raises(OutputError, match="File too large"), file_size_limit(1000):
            RunFolder(out, HEADER)
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["run", "runs"]


@pytest.mark.parametrize("to", ["csv", "npz", "mat", "parquet"])
def test_export_without_room_leaves_nothing(tmp_path: Path, to: str) -> None:
    out = tmp_path / f"run.{to}"
    export(Run(HEADER, ROWS[:2]), to, tmp_path / "small")  # so that imports do not meet the limit
    with pytest.raises(OutputError, match=f"run.{to}: cannot be written: File too large"), file_size_limit(5000):
        export(Run(HEADER, ROWS), to, out)
    assert not list(tmp_path.glob("run*"))


def test_a_folder_that_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_log(tmp_path / "log.mcap", HEADER, ROWS)

    def refuse(*args: Any, **kwargs: Any) -> Any:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)  # the tests may run as root, who is never refused
    from cdpr.base.errors import LogError

    with pytest.raises(LogError, match=r"log\.mcap: cannot be read: Permission denied"):
        load_run(tmp_path)


def test_numbers_that_are_not_finite_become_null_in_run_json(tmp_path: Path) -> None:
    rows = ROWS.copy()
    rows[5:, 1:] = np.nan
    rows[6, 1] = np.inf
    header = make_header(2, tension_max=(np.inf, 1.0))
    run_json.write(tmp_path, run_json.describe(Run(header, rows, "diverged", "NaN")))  # without a warning
    text = (tmp_path / "run.json").read_text()
    content = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} in strict JSON"))
    assert content["header"]["tension_max"] == [None, 1.0]
    assert content["status"] == "diverged"


def test_the_command_ends_with_eight_where_the_disk_fills_up(tmp_path: Path) -> None:
    words = ("run", ROOT / "scenarios" / "caroca.yaml", "--no-report", "--set", "simulation.duration=0.3")
    whole = cdpr_here(
        *words, "--out", tmp_path / "whole", "--json"
    )  # what imports and compiles does not meet the limit
    size = (tmp_path / "whole" / "log.mcap").stat().st_size
    with file_size_limit(size // 2):
        done = cdpr_here(*words, "--out", tmp_path / "run", code=ExitCode.NOT_WRITABLE)
    assert re.search(r"stopped: .*log\.mcap: cannot be written: File too large", done.stderr)
    told = json.loads((tmp_path / "run" / "run.json").read_text())
    assert told["status"] == "failed"
    assert "File too large" in told["message"]
    assert json.loads(whole.stdout)["status"] == "finished"
