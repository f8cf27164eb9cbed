"""Runs whose rows are stored only in the log."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from log_cases import make_header, make_rows, same_bits, write_log
from long_log_cases import CAROCA, SHORT, THINNED, all_on_disk, log_of, simulate_whole, told

import cdpr
from cdpr.base.errors import LogError
from cdpr.log.blocks import BLOCK
from cdpr.log.export import export
from cdpr.log.mcap_file import PICTURE_ROWS
from cdpr.log.reader import load_run
from cdpr.log.recorder import Recorder
from cdpr.log.rows import LogRows
from cdpr.log.run import Run
from cdpr.ui.report.pages.run import render


@pytest.fixture
def on_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    all_on_disk(monkeypatch)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return simulate_whole(tmp_path_factory.mktemp("whole"))


def test_a_run_on_disk_is_the_same_run(whole: Run, on_disk: None, tmp_path: Path) -> None:
    run = cdpr.simulate(CAROCA, overrides=SHORT, out=tmp_path / "run")
    assert log_of(run).read_bytes() == log_of(whole).read_bytes()
    for one in (run, load_run(tmp_path / "run")):
        assert isinstance(one.rows, LogRows)
        assert same_bits(np.array(one.rows), whole.rows)
        assert same_bits(one.acceleration, whole.acceleration)
        assert same_bits(one.energy_residual, whole.energy_residual)
        assert told(one) == told(whole)
        assert one.events == whole.events


def test_rows_on_disk_are_indexed_like_an_array(on_disk: None, tmp_path: Path) -> None:
    header = make_header(3)
    table = make_rows(header, 2 * BLOCK + 40)
    rows = load_run(write_log(tmp_path / "log.mcap", header, table)).rows
    assert isinstance(rows, LogRows)
    keys = (
        *(0, -1, BLOCK, slice(250, 260), slice(None), slice(5, 2), slice(None, None, -7), [3, 300, 3], []),
        *((slice(None), slice(4, 7)), (slice(500, None), slice(0, 1)), np.arange(len(table)) % 9 == 0),
    )
    for key in keys:
        assert same_bits(rows[key], table[key])
    keys = (
        *((slice(None), 0), (0, 3), (slice(None, None, 300), -1), (slice(None, None, 300), [2, 0]), (-1, [2, 0])),
        *(([3, 300], 1), ([3, 300], [1, 4]), ([[3], [300]], [1, 4]), (0, slice(2, 5)), (..., 2), (5, ...), (), (7,)),
        *((slice(3), np.arange(table.shape[1]) % 2 == 0), ([[1, 2], [300, 4]],), (np.int64(4), np.int64(2))),
    )
    for key in keys:
        assert np.shape(rows[key]) == np.shape(table[key]), key
        assert same_bits(np.ascontiguousarray(rows[key]), np.ascontiguousarray(table[key])), key
    assert isinstance(rows[0, 3], float)
    assert rows.shape == table.shape
    assert [row.tobytes() for row in rows] == [row.tobytes() for row in table]
    for key in (len(table), (0, table.shape[1]), (slice(None), -table.shape[1] - 1), (0, 0, 0), None):
        with pytest.raises(IndexError):
            rows[key]


def test_a_log_that_was_changed_afterwards_is_not_believed(on_disk: None, tmp_path: Path) -> None:
    header = make_header(3)
    table = make_rows(header, 3 * BLOCK)
    log = write_log(tmp_path / "log.mcap", header, table)
    run = load_run(log)
    with log.open("r+b") as file:
        file.seek(log.stat().st_size // 2)
        file.write(b"wrong")
    with pytest.raises(LogError, match=r"log\.mcap: rows 256 to 511 are damaged"):
        run.position  # noqa: B018
    os.truncate(log, 5000)
    with pytest.raises(LogError, match="rows 512 to 767 are damaged, or were changed since"):
        run.rows[-1]


def test_rows_on_disk_outlive_the_name_of_their_log(whole: Run, on_disk: None, tmp_path: Path) -> None:
    run = cdpr.simulate(CAROCA, overrides=SHORT, out=tmp_path / "run")
    log_of(run).unlink()
    assert same_bits(run.tension, whole.tension)


def test_a_long_logged_run_keeps_few_rows_in_memory(tmp_path: Path) -> None:
    header = make_header(8)
    recorder = Recorder(header, 3_600_000, tmp_path)
    assert recorder.rows.nbytes < 4e6
    block = make_rows(header, PICTURE_ROWS)
    for stop in range(BLOCK, 4 * PICTURE_ROWS + 1, BLOCK):
        first = stop - BLOCK
        recorder.rows[first % PICTURE_ROWS :][:BLOCK] = block[first % PICTURE_ROWS :][:BLOCK]
        recorder.flush(stop)
    kept = recorder.close(4 * PICTURE_ROWS)
    assert isinstance(kept, LogRows)
    for k in range(4):  # not the time, which in the log follows from the number
        assert same_bits(kept[k * PICTURE_ROWS : (k + 1) * PICTURE_ROWS, 1:], np.ascontiguousarray(block[:, 1:]))


@pytest.mark.slow
@pytest.mark.parametrize("changes", [pytest.param(SHORT, id="whole"), pytest.param(THINNED, id="thinned")])
def test_report_and_exports_of_a_run_on_disk_are_the_same(
    changes: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def made(name: str) -> tuple[str, list[bytes]]:
        run = cdpr.simulate(CAROCA, overrides={**changes, "simulation.duration": 3.0}, out=tmp_path / name)
        assert isinstance(run.rows, LogRows) == (name == "disk")
        files = []
        for to in ("csv", "npz", "parquet"):
            export(run, to, tmp_path / f"{name}.{to}")
            files.append((tmp_path / f"{name}.{to}").read_bytes())
        return render(replace(run, timings={})), files

    memory = made("memory")
    all_on_disk(monkeypatch)
    disk = made("disk")
    assert disk[1] == memory[1]
    ours, theirs = (text.partition('id="robot"') for text in (disk[0], memory[0]))
    assert ours[0] == theirs[0]  # figures and tables of numbers
    after = [text[2].partition('id="tensions"') for text in (ours, theirs)]
    assert after[0][2] == after[1][2]  # all curves; the robot's path is drawn with fewer points


def test_an_npz_is_what_numpy_writes(whole: Run, tmp_path: Path) -> None:
    export(whole, "npz", tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as found:
        arrays = {name: found[name] for name in found.files}
    np.savez(tmp_path / "numpy.npz", **arrays)
    assert (tmp_path / "run.npz").read_bytes() == (tmp_path / "numpy.npz").read_bytes()
    assert same_bits(arrays["tension"], np.ascontiguousarray(whole.tension))


@pytest.mark.parametrize("edit", ["position", "tension", "rows"])
@pytest.mark.parametrize("which", ["memory", "loaded", "disk"])
def test_a_result_cannot_be_edited(which: str, edit: str, whole: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    if which == "disk":
        all_on_disk(monkeypatch)
    run = whole if which == "memory" else load_run(str(whole.folder))
    with pytest.raises((ValueError, TypeError), match=r"read-only|does not support item assignment"):
        getattr(run, edit)[0] = 7.0


@pytest.mark.parametrize("log", [False, True])
@pytest.mark.parametrize("thinned", [False, True])
def test_a_run_can_be_observed_while_it_runs(log, thinned, monkeypatch, tmp_path):
    """`so_far` equals a run that ends there, and does not change the rest of the run."""
    all_on_disk(monkeypatch)
    changes = {**SHORT, "simulation.duration": 0.6, **({"log.step": 0.01} if thinned else {})}
    with cdpr.Simulation(CAROCA, overrides=changes, out=tmp_path / "on" if log else None) as sim:
        looked = []
        for n in (0, 7, 300, 4, 289):
            if n:
                sim.step(n)
            looked.append((sim.samples, sim.so_far()))
            assert same_bits(sim.rows(sim.samples - 3), sim.rows()[-3:] if n else sim.rows())
        last = sim.run()
    whole = cdpr.simulate(CAROCA, overrides=changes)
    assert same_bits(last.rows[:], whole.rows)
    assert last.summary() == {**whole.summary(), "real_time_factor": last.summary()["real_time_factor"]}
    for samples, run in looked:
        assert run.status == ("ended" if samples < 601 else "finished")
        if samples in (0, 601):
            continue
        with cdpr.Simulation(CAROCA, overrides=changes) as sim:
            sim.step(samples)
            short = sim.run()
        assert same_bits(run.rows[:], short.rows[:])
        figures = [{k: v for k, v in each.summary().items() if k != "real_time_factor"} for each in (run, short)]
        assert {**figures[0], "message": ""} == {**figures[1], "message": ""}
