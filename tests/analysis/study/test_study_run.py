"""Running a study: its results, its tables, and going on where it was stopped."""

from __future__ import annotations

import csv
import json
import re
import shutil
import subprocess
import sys
from dataclasses import replace

import pytest
from command_line import cdpr_here
from conftest import ROOT
from sealed_files import edit_lines
from study_cases import TABLES, tables, write_study

import cdpr
from cdpr.analysis.jobs.cases import Outcome
from cdpr.analysis.study import load_study, run_study
from cdpr.analysis.study.figures import FIGURES
from cdpr.analysis.study.folder import StudyFolder, ended
from cdpr.analysis.study.table import _arrow
from cdpr.base import locks
from cdpr.base.errors import ExitCode, LogError, OutputError
from cdpr.scenario import Scenario

SCENARIOS = ROOT / "scenarios"

# Finished, diverged and infeasible: all of them results.
KINDS = """
axes:
  - key: controller.kd
    values: [20, 30]
  - name: kind
    points:
      sound: {controller.kp: 100}
      stiff: {controller.kp: 1.0e+6, simulation.control_step: 0.01, robot.tension.max: 1.0e+11}
      heavy: {solver.infeasible: stop, robot.platform.mass: 10000}
"""


@pytest.fixture(scope="module")
def computed(tmp_path_factory):
    """A finished study of two workers, and its messages."""
    folder = tmp_path_factory.mktemp("study")
    said = []
    results = run_study(load_study(write_study(folder, KINDS)), folder / "out", jobs=2, say=said.append)
    assert said == []
    return results


@pytest.fixture
def results(computed, tmp_path):
    """The same in a folder to spoil."""
    shutil.copytree(computed.folder, tmp_path / "out")
    return computed


def test_results(results, tmp_path):
    assert results.counts == {"finished": 2, "diverged": 2, "infeasible": 2}
    assert results.exit_code == ExitCode.OK
    with (tmp_path / "out" / "table.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["kind"] for row in rows] == ["sound", "stiff", "heavy"] * 2
    for row, case in zip(rows, results.study.cases, strict=True):
        if row["kind"] != "sound":
            continue
        # Results of `cdpr run` for the same scenario, to the bit.
        path = tmp_path / "resolved.yaml"
        path.write_text(case.text)
        summary = cdpr.simulate(path).summary()
        assert float(row["position_error_rms_m"]) == summary["position_error_m"]["rms"]
        assert float(row["tension_max_N"]) == summary["tension_N"]["max"]
        assert int(row["samples"]) == summary["samples"]
    assert "not finite" in rows[1]["message"]
    ideal = [
        name
        for name in FIGURES
        if not name.startswith(
            (
                "cable_tension",
                "beyond",
                "clearance",
                "through",
                "energy_load",
                "lost_steps",
                "motor_",
                "electrical_",
                "estimate_",
            )
        )
    ]
    first = ["case", "controller.kd", "kind", "status", "message"]
    assert list(rows[0]) == [*first, *ideal, "through_anchor_s"]  # of what diverged
    assert {row["energy_balanced"] for row in rows if row["kind"] == "sound"} == {"true"}
    assert not (tmp_path / "out" / "runs").exists()
    heading, first, *_ = (tmp_path / "out" / "times.csv").read_text().splitlines()
    assert float(dict(zip(heading.split(","), first.split(","), strict=True))["case_s"]) > 0


@pytest.mark.parametrize(
    "cells",
    [
        [1.5, None, float("nan"), -0.0, float("inf")],
        [1, None, 2**62, -7],
        [True, None, False, *[True] * 9],
        ["a", None, "", "schräg", "b" * 300],
        [None, None],
        [0.1, 0.2],
        ["x"] * 17,
        [True] * 8,
        [None] * 20 + ["late"],
    ],
)
def test_a_column_is_what_pyarrow_makes_of_it(cells):
    pyarrow = pytest.importorskip("pyarrow")
    ours, theirs = _arrow(pyarrow, cells), pyarrow.array(cells)
    ours.validate(full=True)
    assert ours.type == theirs.type
    assert str(ours.to_pylist()) == str(theirs.to_pylist()) == str(cells)


@pytest.mark.slow
def test_a_table_is_written_without_pandas():
    """It takes as long to import as 60 short cases."""
    pytest.importorskip("pyarrow")
    code = (
        "import sys; from cdpr.analysis.study.table import Table, to_parquet; "
        "print(len(to_parquet(Table((), ('a', 'b'), ('a', 'b'), ((1.0, 'x'), (None, 'y'))))));"
        "assert 'pandas._libs' not in sys.modules"
    )
    assert int(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout) > 100


def test_parquet_holds_the_same(results, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(tmp_path / "out" / "table.parquet")
    assert table.to_pylist() == results.table.records()
    assert str(table.schema.field("tension_max_N").type) == "double"
    assert str(table.schema.field("samples").type) == "int64"


def test_tables_do_not_depend_on_the_number_of_workers(results, tmp_path):
    run_study(results.study, tmp_path / "one", jobs=1)
    assert tables(tmp_path / "one") == tables(tmp_path / "out")


def test_only_what_is_missing_runs(results, tmp_path):
    """Also after a line was torn, and with the same tables in the end."""
    out = tmp_path / "out"
    whole, ledger = tables(out), (out / "cases.jsonl").read_bytes()
    lines = ledger.splitlines(keepends=True)
    (out / "cases.jsonl").write_bytes(b"".join(lines[:3]) + lines[3][:50])
    for name in TABLES:
        (out / name).unlink()
    calls = []
    run_study(results.study, out, jobs=2, progress=lambda done, total, counts: calls.append(done))
    assert calls == [3, 4, 5, 6]
    assert tables(out) == whole
    again = (out / "cases.jsonl").read_bytes().splitlines(keepends=True)
    assert again[:3] == lines[:3]
    assert len(again) == 6
    run_study(results.study, out, progress=lambda done, total, counts: calls.append(done))
    assert calls[4:] == [6]  # nothing is left of the torn line


def test_a_folder_belongs_to_one_study(results, tmp_path):
    other = load_study(write_study(tmp_path, KINDS.replace("[20, 30]", "[20, 40]")))
    with pytest.raises(OutputError, match="contains another study, 'study' of 6 cases"):
        run_study(other, tmp_path / "out")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "letter").touch()
    with pytest.raises(OutputError, match="is not empty and contains no study"):
        run_study(results.study, tmp_path / "full")


def test_the_second_process_uses_files_of_the_first(results, tmp_path, monkeypatch):
    """The folder was empty when it looked, and contains another study when it has the lock."""
    other = load_study(write_study(tmp_path, KINDS.replace("[20, 30]", "[20, 40]")))

    def late(file):
        shutil.copy(tmp_path / "out" / "study.json", tmp_path / "new")
        return locks.lock(file)

    monkeypatch.setattr("cdpr.analysis.jobs.folder.lock", late)
    with pytest.raises(OutputError, match="contains another study"):
        StudyFolder(tmp_path / "new", other)


@pytest.mark.parametrize("line", ["{", '{"key": "a"}', "[]", '{"key": "a", "status": 1, "message": "", "folder": ""}'])
def test_a_corrupt_ledger_is_reported(results, tmp_path, line):
    with (tmp_path / "out" / "cases.jsonl").open("a") as file:
        file.write(line + "\n")
    with pytest.raises(LogError, match=r"cases\.jsonl:7: cannot be read .*remove that line"):
        run_study(results.study, tmp_path / "out")


def test_the_reason_is_the_first_line():
    assert Outcome("a", "died", "by SIGSEGV\nFatal Python error", "").reason == "by SIGSEGV"


def test_other_versions_are_reported(results, tmp_path):
    ledger = tmp_path / "out" / "cases.jsonl"
    numpy = json.loads(ledger.read_text().splitlines()[0])["versions"]["numpy"]
    edit_lines(ledger, lambda row: row["versions"].update(numpy="1.0"), 0, 1)
    said = []
    run_study(results.study, tmp_path / "out", say=said.append)
    assert len(said) == 1
    assert f"numpy 1.0, here {numpy} (2 cases)" in said[0]


def test_runs_that_miss_their_wrench_are_reported(tmp_path):
    heavy = "axes: [{key: robot.platform.mass, values: [150, 10000]}]\n"
    results = run_study(load_study(write_study(tmp_path, heavy)), tmp_path / "out")
    assert results.strained == 1
    assert results.summary_text == "2 finished; 1 with samples without valid tensions"


@pytest.mark.parametrize(("keep", "kept"), [("all", 6), ("failed", 4)])
def test_kept_runs(tmp_path, keep, kept):
    results = run_study(load_study(write_study(tmp_path, f"keep: {keep}\n" + KINDS)), tmp_path / "out", jobs=2)
    folders = sorted((tmp_path / "out" / "runs").iterdir())
    assert len(folders) == kept
    for folder in folders:
        (case,) = (case for case in results.study.cases if case.id == folder.name)
        assert (folder / "scenario.yaml").read_text() == case.text
        assert cdpr.load_run(folder).status == results.rows[case.id].status


def command(study, out, *options, code=0):
    return cdpr_here("study", study, "--out", out, "--no-report", *options, code=code)


def test_command(tmp_path):
    study, out = write_study(tmp_path, KINDS), tmp_path / "out"
    told = json.loads(command(study, out, "--jobs", "2", "--json").stdout)
    assert told["counts"] == {"finished": 2, "diverged": 2, "infeasible": 2}
    assert [row["controller.kd"] for row in told["cases"]] == [20, 20, 20, 30, 30, 30]
    again = command(study, out).stdout
    assert "6 cases: 2 finished, 2 diverged, 2 infeasible" in again
    assert again.rstrip().endswith(str(out))
    assert "6 cases, all valid" in command(study, tmp_path / "no", "--dry-run").stdout
    assert not (tmp_path / "no").exists()


@pytest.mark.parametrize(
    ("found", "code"),
    [
        ([("infeasible", 4), ("diverged", 5)], ExitCode.OK),
        ([("failed", 3), ("failed", 8)], ExitCode.PLUGIN),
        ([("failed", 3), ("hung", 6)], ExitCode.BACKEND_DIED),
    ],
)
def test_exit_codes(computed, found, code):
    rows = dict(computed.rows)
    for case, (status, number) in zip(computed.study.cases, found, strict=False):
        rows[case.id] = replace(rows[case.id], status=status, code=ExitCode(number))
    assert replace(computed, rows=rows).exit_code == code


def test_a_bad_study_runs_nothing(tmp_path):
    study = write_study(tmp_path, "axes:\n  - {key: controller.kp, values: [1, -1]}")
    done = command(study, tmp_path / "out", code=ExitCode.BAD_INPUT)
    assert "study.yaml:4:38: controller.kp: must be" in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_resume_checks_only_what_has_no_result(tmp_path, monkeypatch):
    """Of the same scenario, changes and versions the check has the same result."""
    text = "axes:\n  - {key: controller.kp, values: [100, 200, 300, 400]}"
    path, out, checked = write_study(tmp_path, text), tmp_path / "out", []
    change = Scenario.with_changes

    def counted(self, *arguments, **options):
        checked.append(None)
        return change(self, *arguments, **options)

    def load():
        checked.clear()
        return load_study(path, ended=ended(out))

    monkeypatch.setattr(Scenario, "with_changes", counted)
    study = load()
    assert len(checked) == 4
    folder = StudyFolder(out, study)
    for case in study.cases[:3]:
        status = "died" if case is study.cases[2] else "finished"
        folder.record(Outcome(case.id, status, "", "", {"samples": 1}, case.versions))
    folder.close()
    again = load()
    assert len(checked) == 2  # what died is tried again
    assert again.digest == study.digest
    assert [case.id for case in again.cases] == [case.id for case in study.cases]
    StudyFolder(out, again).close()
    path.write_text(path.read_text() + "\nseed: 5\n")  # other cases, though they change the same
    other = load()
    assert len(checked) == 4
    with pytest.raises(OutputError, match="contains another study"):
        StudyFolder(out, other)
    path.write_text(path.read_text().replace("\nseed: 5\n", ""))
    monkeypatch.setattr("cdpr.simulation.header.VERSION", "9.9")
    assert load().digest == study.digest
    assert len(checked) == 4


def test_a_file_that_an_axis_names_is_read_again(tmp_path):
    """Results of another robot by the same name are not taken for those of this one."""
    (tmp_path / "robots").mkdir()
    for name in ("caroca", "other"):
        shutil.copy(SCENARIOS / "robots" / "caroca.yaml", tmp_path / "robots" / f"{name}.yaml")
    shutil.copy(SCENARIOS / "caroca.yaml", tmp_path)
    path, out = tmp_path / "study.yaml", tmp_path / "out"
    path.write_text("scenario: caroca.yaml\naxes:\n  - {key: robot, values: [robots/caroca.yaml, robots/other.yaml]}\n")
    study = load_study(path)
    folder = StudyFolder(out, study)
    for case in study.cases:
        folder.record(Outcome(case.id, "finished", "", "", {"samples": 1}, case.versions))
    folder.close()
    assert load_study(path, ended=ended(out)).digest == study.digest
    robot = tmp_path / "robots" / "other.yaml"
    robot.write_text(re.sub(r"mass: *[0-9.]+", "mass: 77.0", robot.read_text()))
    with pytest.raises(OutputError, match="contains another study"):
        StudyFolder(out, load_study(path, ended=ended(out)))


def test_results_that_vanish_meanwhile_are_reported(tmp_path):
    path, out = write_study(tmp_path, "axes:\n  - {key: controller.kp, values: [100, 200]}"), tmp_path / "out"
    study = load_study(path)
    folder = StudyFolder(out, study)
    for case in study.cases:
        folder.record(Outcome(case.id, "finished", "", "", {"samples": 1}, case.versions))
    folder.close()
    again = load_study(path, ended=ended(out))
    (out / "cases.jsonl").write_text("")
    with pytest.raises(OutputError, match="lost results since it was read"):
        run_study(again, out)
