"""Runs of which the log keeps some samples: those of its grid, and the last."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from log_cases import make_header, make_rows, same_bits, write_log
from long_log_cases import CAROCA, END, EVERY, THINNED, all_on_disk, log_of, simulate_whole, told
from sealed_files import edit_file

import cdpr
from cdpr.analysis.compare.finished import compare_finished
from cdpr.base.errors import CdprError, ScenarioError
from cdpr.log import recorder as recorder_module
from cdpr.log.blocks import BLOCK
from cdpr.log.mcap_file import PICTURE_ROWS
from cdpr.log.reader import load_run, scan
from cdpr.log.recorder import Recorder
from cdpr.log.repair import repair
from cdpr.log.rows import LogRows
from cdpr.log.run import Run
from cdpr.ui.report.text.compare import lines, subject

pytestmark = pytest.mark.core


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return simulate_whole(tmp_path_factory.mktemp("whole"))


@pytest.fixture(scope="module")
def thin(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """The same run of which every tenth sample is kept."""
    return cdpr.simulate(CAROCA, overrides=THINNED, out=tmp_path_factory.mktemp("thin") / "run")


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
    assert log_of(run).stat().st_size < log_of(whole).stat().st_size / 6.5


def test_a_thinned_log_contains_its_counts(thin: Run, tmp_path: Path) -> None:
    (tmp_path / "alone.mcap").write_bytes(log_of(thin).read_bytes())
    found = load_run(tmp_path / "alone.mcap").summary()
    assert (found["samples"], found["logged_samples"], found["simulated_s"]) == (152, 152, END)


def test_other_programs_read_a_thinned_log(thin: Run) -> None:
    from mcap.reader import make_reader

    with log_of(thin).open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        times = [m.log_time for _, c, m in reader.iter_messages(topics=["/cdpr/energy"])]
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


def test_a_stopped_thinned_run_keeps_the_violating_sample(tmp_path: Path) -> None:
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
    begun = {"status": "running", "summary": {"samples": 0, "simulated_s": 0.0, "infeasible_steps": 0}}
    edit_file(tmp_path / "run" / "run.json", lambda about: about.update(begun))
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


def test_runs_of_different_log_steps_are_not_compared(whole: Run, thin: Run) -> None:
    with pytest.raises(CdprError, match=r"other log step \(0\.01 instead of 0\.001\)"):
        compare_finished([str(whole.folder), str(thin.folder)])


def test_runs_of_one_log_step_are_compared(thin: Run, tmp_path: Path) -> None:
    cdpr.simulate(CAROCA, overrides=THINNED, out=tmp_path / "again")
    found = compare_finished([str(thin.folder), str(tmp_path / "again")])
    assert found.figures["duration_s"] == END
    assert "compared are 152 of 1506 samples" in subject(found.figures)
    text = "\n".join(lines(found.figures))
    assert "not in the compared samples, so perhaps not covered" in " ".join(text.split())
    assert "not covered by this scenario" not in text
    assert [row["outcome"] for group in found.figures["groups"] for row in group["engines"]] == ["agrees"]


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
