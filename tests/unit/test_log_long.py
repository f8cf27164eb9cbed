"""Runs whose rows stand in the log alone, and runs of which the log keeps some samples."""

from __future__ import annotations

import json
import os
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from log_cases import make_header, make_rows, same_bits, write_log

import cdpr
from cdpr.compare.finished import compare_finished
from cdpr.errors import CdprError, LogError, ScenarioError
from cdpr.log import reader as reader_module
from cdpr.log import recorder as recorder_module
from cdpr.log import summary as summary_module
from cdpr.log.export import export
from cdpr.log.mcap_file import BLOCK, PICTURE_ROWS
from cdpr.log.reader import load_run, scan
from cdpr.log.recorder import Recorder
from cdpr.log.repair import repair
from cdpr.log.rows import LogRows
from cdpr.log.run import Run
from cdpr.log.summary import SUMMED, Tally
from cdpr.report.pages.run import render
from cdpr.report.plots import histories
from cdpr.report.text.compare import lines, subject

CAROCA = Path(__file__).parent.parent.parent / "scenarios" / "caroca.yaml"
EVENTS = [
    {"type": "cable_jam", "time": 0.503, "cable": "cable_3", "detected_after": 0.1},
    {"type": "limits", "time": 1.002, "max": 60.0},  # no tensions below that hold the platform
    {"type": "limits", "time": 1.057, "max": 650.0},
]
SHORT: dict[str, Any] = {"simulation.duration": 1.505, "events": EVENTS}
THINNED = {**SHORT, "log.step": 0.01}
EVERY = 10
END = 1505 * 0.001  # s


def all_on_disk(patch: pytest.MonkeyPatch) -> None:
    """Every logged run counts as long; no more than a few blocks are looked at together."""
    for module in (recorder_module, reader_module):
        patch.setattr(module, "IN_MEMORY", 0)
    for module in (summary_module, histories):
        patch.setattr(module, "PIECE", 300)


@pytest.fixture
def on_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    all_on_disk(monkeypatch)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A run that stays in memory, with a fault and samples without valid tensions."""
    run = cdpr.simulate(CAROCA, overrides=SHORT, out=tmp_path_factory.mktemp("whole") / "run")
    assert run.summary()["infeasible_steps"] > 0
    assert isinstance(run.rows, np.ndarray)
    return run


@pytest.fixture(scope="module")
def thin(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """The same run of which every tenth sample is kept."""
    return cdpr.simulate(CAROCA, overrides=THINNED, out=tmp_path_factory.mktemp("thin") / "run")


def told(run: Run) -> dict[str, Any]:
    """The summary without what the clock on the wall says."""
    return {key: value for key, value in run.summary().items() if key != "real_time_factor"}


def log_of(run: Run) -> Path:
    return Path(str(run.folder)) / "log.mcap"


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
    with pytest.raises(LogError, match="has changed"):
        run.position  # noqa: B018
    os.truncate(log, 5000)
    with pytest.raises(LogError, match="has changed: its rows 512 to 767"):
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


@pytest.mark.parametrize("cut", [7, 256, 1000, 5000])
def test_the_summary_does_not_depend_on_the_pieces(cut: int) -> None:
    header = make_header(4)
    rows = make_rows(header, 2 * SUMMED + 345)
    one, many = Tally(header, len(rows)), Tally(header, len(rows))
    one.add(rows)
    for first in range(0, len(rows), cut):
        many.add(rows[first : first + cut])
    assert many.figures() == one.figures()
    assert same_bits(many.status, one.status)
    run = Run(header, rows)
    for name, error in (("position_error_m", run.position_error), ("orientation_error_rad", run.orientation_error)):
        assert one.figures()[name]["rms"] == pytest.approx(np.sqrt(np.mean(np.sum(error**2, axis=1))), rel=1e-14)


def test_the_summary_is_that_of_plain_formulas() -> None:
    header = make_header(4)
    run = Run(header, make_rows(header, 2345))
    found = run.summary()
    norms = np.linalg.norm(run.position_error, axis=1)
    assert found["position_error_m"] == {"max": norms.max(), "rms": np.sqrt(np.mean(norms**2)), "final": norms[-1]}
    steps = np.abs(np.diff(run.tension, axis=0))
    assert found["tension_N"] == {
        "min": run.tension.min(),
        "max": run.tension.max(),
        "largest_step": steps.max(),
    }
    assert found["energy_J"]["residual_max"] == np.abs(run.energy_residual).max()
    assert (found["residual_max_N"], found["margin_min_N"]) == (run.residual.max(), run.margin.min())
    assert found["infeasible_steps"] + found["unanswered_steps"] == np.count_nonzero(run.solver_status)


def test_nan_is_not_lost_between_pieces() -> None:
    header = make_header(2)
    rows = make_rows(header, 30)
    rows[12, header.layout.columns["residual"]] = np.nan
    tally = Tally(header, 30)
    for first in range(0, 30, 10):
        tally.add(rows[first : first + 10])
    assert np.isnan(tally.figures()["residual_max_N"])


@pytest.mark.parametrize("disk", [False, True])
def test_a_thinned_run_holds_the_samples_of_its_grid_and_the_last(
    whole: Run, disk: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if disk:
        all_on_disk(monkeypatch)
    expected = np.concatenate([whole.rows[::EVERY], whole.rows[-1:]])
    run = cdpr.simulate(CAROCA, overrides=THINNED, out=tmp_path / "run")
    loaded = load_run(tmp_path / "run")
    in_memory = cdpr.simulate(CAROCA, overrides=THINNED)
    for one in (run, loaded, in_memory):
        assert isinstance(one.rows, LogRows) == (disk and one is not in_memory)
        assert same_bits(np.array(one.rows), expected)
        counted = {"log_step_s": 0.01, "logged_samples": 152}
        assert told(one) == told(whole) | counted
        assert one.events == whole.events
    assert same_bits(run.time[-2:], np.array([1.5, END]))
    assert same_bits(run.acceleration[:-1], np.diff(run.velocity, axis=0) / np.diff(run.time)[:, None])
    # A tenth of the rows; the pictures for viewers have a rate of their own.
    assert log_of(run).stat().st_size < log_of(whole).stat().st_size / 7


def test_a_thinned_log_alone_says_what_it_counts(thin: Run, tmp_path: Path) -> None:
    (tmp_path / "alone.mcap").write_bytes(log_of(thin).read_bytes())
    found = load_run(tmp_path / "alone.mcap").summary()
    assert (found["samples"], found["logged_samples"], found["simulated_s"]) == (152, 152, END)


def test_other_programs_read_a_thinned_log(thin: Run) -> None:
    from mcap.reader import make_reader

    with log_of(thin).open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        times = [m.log_time for _, c, m in reader.iter_messages(topics=["/clock"])]
        frames = [m.log_time for _, c, m in reader.iter_messages(topics=["/tf"])]
    assert times == [*range(0, 1_500_000_001, 10_000_000), 1_505_000_000]
    assert summary.statistics.message_end_time == times[-1]
    assert frames == times[:-1:2]  # at most 60 a second


def test_every_cut_of_a_thinned_log_gives_its_beginning(thin: Run, tmp_path: Path) -> None:
    data = log_of(thin).read_bytes()
    torn = tmp_path / "log.mcap"
    whole_rows = np.array(thin.rows)
    for size in np.linspace(len(data) // 3, len(data) - 1, 12).astype(int):
        torn.write_bytes(data[:size])
        found = scan(torn)
        assert found.problem is not None
        assert same_bits(np.array(found.rows), whole_rows[: len(found.rows)])
    repair(torn)
    again = scan(torn)
    assert again.problem is None
    assert same_bits(np.array(again.rows), whole_rows)


def test_a_thinned_log_is_the_same_however_it_was_flushed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder_module, "IN_MEMORY", 0)
    monkeypatch.setattr(recorder_module, "BLOCK_SECONDS", -1.0)  # write at each flush
    header = make_header(2, log_every=3)
    rows = make_rows(header, 3 * PICTURE_ROWS + 50)
    kept = rows[::3] if (len(rows) - 1) % 3 == 0 else np.concatenate([rows[::3], rows[-1:]])
    recorder = Recorder(header, len(rows) - 1, tmp_path, marks=[5000])
    random = np.random.default_rng(0)
    stop = 0
    while stop < len(rows):
        first, stop = stop, min(stop + int(random.integers(1, BLOCK)), (stop // BLOCK + 1) * BLOCK, len(rows))
        recorder.rows[first % PICTURE_ROWS :][: stop - first] = rows[first:stop]
        recorder.flush(stop)
    for _ in range(2):
        assert same_bits(np.array(recorder.close(len(rows))), kept)
    whole_log = write_log(tmp_path / "whole.mcap", header, np.ascontiguousarray(kept))
    assert (tmp_path / "log.mcap").read_bytes() == whole_log.read_bytes()
    assert same_bits(recorder.marked[5000], rows[5000])
    assert same_bits(recorder.status, rows[:, header.layout.columns["status"].start].astype(np.int8))


def test_a_thinned_run_that_stops_keeps_the_sample_that_tells_why(tmp_path: Path) -> None:
    changes = {**THINNED, "solver.infeasible": "stop"}
    with pytest.raises(cdpr.Infeasible) as caught:
        cdpr.simulate(CAROCA, overrides=changes, out=tmp_path / "run")
    run = caught.value.run
    assert isinstance(run, Run)
    assert (run.time[-1], run.solver_status[-1]) == (1002 * 0.001, 1.0)
    assert run.summary()["samples"] == 1003
    loaded = load_run(tmp_path / "run")
    assert same_bits(np.array(loaded.rows), np.array(run.rows))
    assert told(loaded) == told(run)


def test_a_killed_thinned_run_counts_what_is_in_its_log(tmp_path: Path) -> None:
    run = cdpr.simulate(CAROCA, overrides=THINNED, out=tmp_path / "run")
    about = json.loads((tmp_path / "run" / "run.json").read_text())
    about |= {"status": "running", "summary": {"samples": 0, "simulated_s": 0.0, "infeasible_steps": 0}}
    (tmp_path / "run" / "run.json").write_text(json.dumps(about))
    log_of(run).write_bytes(log_of(run).read_bytes()[:-2000])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert load_run(tmp_path / "run").summary()["samples"] > 100
    repair(tmp_path / "run")
    found = load_run(tmp_path / "run")
    assert (found.status, found.summary()["samples"]) == ("interrupted", len(found.rows))


def test_unthinned_logs_and_headers_are_those_of_before(whole: Run, thin: Run) -> None:
    assert "log_every" not in whole.header.to_dict()
    assert "log:" not in whole.header.scenario_yaml
    assert thin.header.to_dict()["log_every"] == EVERY
    assert replace(thin.header, log_every=1, scenario_yaml=whole.header.scenario_yaml) == whole.header


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


def test_runs_of_different_log_steps_are_not_compared(whole: Run, thin: Run) -> None:
    with pytest.raises(CdprError, match=r"other log step \(0\.01 instead of 0\.001\)"):
        compare_finished([str(whole.folder), str(thin.folder)])


def test_runs_of_one_log_step_are_compared(thin: Run, tmp_path: Path) -> None:
    cdpr.simulate(CAROCA, overrides=THINNED, out=tmp_path / "again")
    found = compare_finished([str(thin.folder), str(tmp_path / "again")])
    assert found.figures["duration_s"] == END
    assert "compared are 152 of 1506 samples" in subject(found.figures)
    text = "\n".join(lines(found.figures))
    assert "not in the samples that are compared, so perhaps not put to the test" in " ".join(text.split())
    assert "does not happen" not in text
    assert [row["outcome"] for group in found.figures["groups"] for row in group["engines"]] == ["agrees"]


@pytest.mark.parametrize("edit", ["position", "tension", "rows"])
@pytest.mark.parametrize("which", ["memory", "loaded", "disk"])
def test_a_result_cannot_be_edited(which: str, edit: str, whole: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    if which == "disk":
        all_on_disk(monkeypatch)
    run = whole if which == "memory" else load_run(str(whole.folder))
    with pytest.raises((ValueError, TypeError), match=r"read-only|does not support item assignment"):
        getattr(run, edit)[0] = 7.0


@pytest.mark.parametrize(
    ("step", "words"),
    [
        (0.0015, "log.step: must be an integer multiple of control_step, 0.001 (s), got 0.0015; nearest: 0.001 or"),
        (0.0, "log.step"),
        (-0.01, "log.step"),
        ("often", "log.step"),
    ],
)
def test_a_log_step_is_a_whole_multiple_of_the_control_step(step: object, words: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        cdpr.load_scenario(CAROCA, overrides={"log.step": step})
    assert len(caught.value.problems) == 1
    assert words in str(caught.value.problems[0])


def test_a_log_step_beyond_the_run_keeps_its_ends() -> None:
    run = cdpr.simulate(CAROCA, overrides={"simulation.duration": 0.05, "log.step": 1e9})
    assert run.time.tolist() == [0.0, 0.05]


@pytest.mark.parametrize("log", [False, True])
@pytest.mark.parametrize("thinned", [False, True])
def test_a_run_is_looked_at_while_it_goes_on(log, thinned, monkeypatch, tmp_path):
    """What `so_far` returns is what a run that ends there has; the run that goes on has what it would have had."""
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
