"""Studies under fire: workers killed, hanging and raising, the whole study killed; what is finished stays."""

from __future__ import annotations

import json
import os
import signal
import subprocess

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT
from study_cases import command, environment, faulty_study, tables, wait_until, write_study

from cdpr.base.errors import ExitCode

pytestmark = pytest.mark.usefixtures("faulty_plugin")


def run(study, out, *options):
    return cdpr_here("study", study, "--out", out, "--no-report", *options, code=None)


def ledger(out):
    """Return the content of each line, in the order of writing, without an incomplete last line."""
    text = (out / "cases.jsonl").read_text()
    return [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]


def children(pid):
    """Children of a process (Linux)."""
    with open(f"/proc/{pid}/task/{pid}/children") as file:
        return [int(child) for child in file.read().split()]


def workers_of(study):
    """The processes in which the cases of a study run: they fork from its only child."""
    (server,) = children(study)
    return children(server)


def undisturbed(study, folder, count):
    """The tables of the same study without any fault: all files are there."""
    for i in range(count):
        (folder / "faults" / f"{i}").touch()
    done = run(study, folder / "undisturbed", "--jobs", "2")
    assert done.returncode == 0, done.stderr
    for i in range(count):
        (folder / "faults" / f"{i}").unlink()
    return tables(folder / "undisturbed")


def rerun_equals(study, out, expected):
    """Run what is missing; return the lines of the ledger that were written before."""
    before = ledger(out)
    finished = {row["key"] for row in before if row["status"] == "finished"}
    done = run(study, out, "--jobs", "2", "--timeout", "5")
    assert done.returncode == 0, done.stderr
    after = ledger(out)
    assert after[: len(before)] == before
    assert not {row["key"] for row in after[len(before) :]} & finished  # nothing finished was run again
    assert tables(out) == expected
    return before


@pytest.mark.slow
def test_faults_cost_their_own_case_and_a_rerun_mends_them(tmp_path):
    faults = ["none", "raise", "kill", "hang", "crash", "none", "exit", "none"]
    study = faulty_study(tmp_path, faults, 0.1)
    expected = undisturbed(study, tmp_path, len(faults))
    out = tmp_path / "out"
    first = run(study, out, "--jobs", "2", "--timeout", "2")
    assert first.returncode == ExitCode.BACKEND_DIED
    assert "3 cases died; trying again" in first.stderr
    assert "8 cases: 6 finished, 1 failed, 1 hung" in first.stdout
    assert "hung: no answer after 2 s" in first.stdout
    lines = rerun_equals(study, out, expected)
    assert len(lines) == len(faults) + 3  # each once, and the dead again


@pytest.mark.slow
def test_a_case_that_always_dies_is_recorded(tmp_path):
    study = write_study(tmp_path, "axes:\n  - {key: controller.fault, values: [none, kill]}")
    study.write_text(study.read_text().replace("changes: {", "changes: {controller.type: faulty, "))
    done = run(study, tmp_path / "out", "--jobs", "2", "--json")
    assert done.returncode == ExitCode.BACKEND_DIED
    rows = json.loads(done.stdout)["cases"]
    assert [row["status"] for row in rows] == ["finished", "died"]
    assert rows[1]["message"] == "the process of this case was ended by SIGKILL"


@pytest.fixture(scope="module")
def sound(faulty_plugin, tmp_path_factory):
    """A study without faults, and its tables."""
    folder = tmp_path_factory.mktemp("sound")
    study = faulty_study(folder, ["none"] * 6, 1.5)
    return study, undisturbed(study, folder, 6)


@pytest.mark.slow  # each runs a study three times
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_a_stopped_study_continues(sound, tmp_path, number):
    study, expected = sound
    out = tmp_path / "out"
    process = subprocess.Popen(
        command(study, out, "--jobs", "2"), env=environment(), cwd=ROOT, stderr=subprocess.PIPE, text=True
    )
    wait_for_cases(process, out, 2)
    workers = [*children(process.pid), *workers_of(process.pid)]
    assert len(workers) == 1 + 2
    process.send_signal(number)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGKILL: -9}[number]
    wait_until(lambda: not any(alive(pid) for pid in workers))
    if number != signal.SIGKILL:
        assert f"interrupted; continue by: cdpr study {study} " in errors
        assert f" --out {out}\n" in errors
        assert ",not run," in (out / "table.csv").read_text()
    rerun_equals(study, out, expected)


@pytest.mark.slow
def test_two_studies_in_one_folder(tmp_path):
    study = write_study(tmp_path, "axes:\n  - {key: controller.fault, values: [hang]}")
    study.write_text(study.read_text().replace("changes: {", "changes: {controller.type: faulty, "))
    out = tmp_path / "out"
    process = subprocess.Popen(command(study, out), env=environment(), cwd=ROOT, stderr=subprocess.PIPE)
    wait_until((out / "cases.jsonl").exists)
    second = run(study, out, "--timeout", "2")
    assert second.returncode == ExitCode.NOT_WRITABLE
    assert "another cdpr study is at work there" in second.stderr
    process.kill()
    process.communicate()


@pytest.mark.slow
def test_two_hundred_cases(tmp_path):
    """Ten workers killed from outside, five cases hang, five raise, the study is killed: a rerun gives the same."""
    count = 200
    faults = ["none"] * count
    for case in (86, 88, 90, 98, 106):  # after those that are killed
        faults[case] = "raise"
    for case in (92, 94, 150, 160, 170):  # some before the study is killed, some after
        faults[case] = "hang"
    study = faulty_study(tmp_path, faults, 2.0)
    expected = undisturbed(study, tmp_path, count)
    out = tmp_path / "out"
    process = subprocess.Popen(
        command(study, out, "--jobs", "2", "--timeout", "3"), env=environment(), cwd=ROOT, stderr=subprocess.PIPE
    )
    rng = np.random.default_rng(4)
    for kill in range(10):
        wait_for_cases(process, out, 7 + 7 * kill)
        os.kill(int(rng.choice(workers_of(process.pid))), signal.SIGKILL)
    wait_for_cases(process, out, 120)
    process.kill()
    process.communicate()
    lost = [row for row in ledger(out) if row["status"] != "finished"]
    # A worker that is killed between two cases, or while it starts, costs none.
    assert 5 <= sum(row["status"] == "died" for row in lost) <= 10
    assert all("SIGKILL" in row["message"] for row in lost if row["status"] == "died")
    # The last cases hang in the first rerun; the second mends them.
    run(study, out, "--jobs", "2", "--timeout", "3")
    rerun_equals(study, out, expected)
    rows = ledger(out)
    assert sum(row["status"] == "hung" for row in rows) == 5
    assert sum(row["status"] == "failed" for row in rows) == 5
    assert sum(row["status"] == "finished" for row in rows) == count


def alive(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def wait_for_cases(process, out, count):
    def there():
        assert process.poll() is None, process.stderr.read()
        path = out / "cases.jsonl"
        return path.exists() and path.read_bytes().count(b"\n") >= count

    wait_until(there)
