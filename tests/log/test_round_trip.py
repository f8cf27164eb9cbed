"""Loaded rows equal recorded rows to the bit, for any flushes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import EXAMPLES
from counted import calls
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from log_cases import make_header, make_rows, same_bits, write_log

from cdpr.log.blocks import BLOCK
from cdpr.log.layout import Layout
from cdpr.log.mcap_file import PICTURE_ROWS
from cdpr.log.reader import load_run
from cdpr.log.recorder import Recorder
from cdpr.model.robot import Array

pytestmark = pytest.mark.core

BITS = st.integers(0, 2**64 - 1)  # any number, NaN with any payload, -0.0 and denormals among them


def bit_patterns(k: int, width: int) -> st.SearchStrategy[Array]:
    return arrays(np.uint64, (k, width), elements=BITS).map(lambda bits: bits.view(np.float64))


@given(st.data())
def test_any_numbers(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    m = data.draw(st.sampled_from([1, 3, 8, 12]))
    k = data.draw(st.integers(1, 5))
    header = make_header(m, control_step=data.draw(st.floats(1e-5, 1.0)))
    rows = data.draw(bit_patterns(k, Layout(m).width))
    rows[:, 0] = [i * header.control_step for i in range(k)]
    path = write_log(tmp_path_factory.mktemp("run") / "log.mcap", header, rows)
    run = load_run(path)
    assert run.header == header
    assert same_bits(run.rows, rows)


@pytest.mark.parametrize("k", [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, PICTURE_ROWS, PICTURE_ROWS + 1])
@pytest.mark.parametrize("m", [1, 8])
def test_any_count(tmp_path: Path, k: int, m: int) -> None:
    header = make_header(m)
    rows = make_rows(header, k)
    run = load_run(write_log(tmp_path / "log.mcap", header, rows))
    assert same_bits(run.rows, rows)
    assert (run.status, run.folder) == ("finished", str(tmp_path))


@settings(max_examples=min(EXAMPLES, 25))
@given(st.lists(st.integers(1, 700), max_size=8), st.integers(0, 900))
def test_bytes_do_not_depend_on_flushing(tmp_path_factory: pytest.TempPathFactory, gaps: list[int], rest: int) -> None:
    header = make_header(2)
    stops = np.cumsum([0, *gaps]).tolist()
    rows = make_rows(header, stops[-1] + rest)
    folder = tmp_path_factory.mktemp("run")
    recorder = Recorder(header, len(rows) + 5, folder)
    for stop in stops:
        recorder.rows[:stop] = rows[:stop]
        recorder.flush(stop)
    recorder.rows[: len(rows)] = rows
    assert same_bits(recorder.close(len(rows)), rows)
    whole = write_log(folder / "whole.mcap", header, rows)
    assert (folder / "log.mcap").read_bytes() == whole.read_bytes()


@pytest.mark.parametrize("stop", [1, 100, BLOCK, 3 * BLOCK + 5, PICTURE_ROWS + 40])
def test_flushed_rows_can_be_loaded_during_the_run(tmp_path: Path, stop: int) -> None:
    header = make_header(4)
    rows = make_rows(header, stop)
    recorder = Recorder(header, stop + 10, tmp_path)
    recorder.rows[:stop] = rows
    recorder.flush(stop)
    assert recorder._writer is not None
    recorder._writer.out.wait()  # a thread writes full blocks
    with pytest.warns(UserWarning, match=f"cut off at byte .*; {stop} rows kept. `cdpr repair"):
        run = load_run(tmp_path)
    assert run.status == "running"
    assert same_bits(run.rows, rows)
    for _ in range(2):
        recorder.close(stop)
        assert same_bits(load_run(tmp_path).rows, rows)


def test_without_a_folder_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    header = make_header(3)
    recorder = Recorder(header, 4)
    recorder.rows[:] = make_rows(header, 5)
    recorder.flush(3)
    assert len(recorder.close(4)) == 4
    assert list(tmp_path.iterdir()) == []


def test_a_large_log_is_loaded_by_blocks(tmp_path: Path) -> None:
    header = make_header(8)
    rows = np.tile(make_rows(header, 1000), (20, 1))
    rows[:, 0] = np.arange(20_000) * header.control_step
    path = write_log(tmp_path / "log.mcap", header, rows)
    run, count = calls(lambda: load_run(path))
    assert count < len(rows) + 20_000  # 17000, of which 300 for each thousand rows; a message at a time it is 200000
    assert same_bits(run.rows, rows)
