"""A killed design: evaluations are kept, and the same command continues to the same result."""

from __future__ import annotations

import json
import signal
import subprocess
import sys

import pytest
from command_line import cdpr_here
from design_cases import kept, write_design
from study_cases import wait_until

JOBS = 2


def lines(out):
    """Whole lines of the ledger."""
    path = out / "cases.jsonl"
    return path.read_bytes().count(b"\n") if path.exists() else 0


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
def test_a_killed_design_continues(how, tmp_path):
    path, count = write_design(tmp_path, optimizer="evaluations: 200, seed: 5"), 200
    cdpr_here("design", path, "--out", tmp_path / "whole", "--jobs", "1", "--no-report")
    out = tmp_path / "out"
    command = [sys.executable, "-m", "cdpr", "design", str(path), "--out", str(out), "--jobs", str(JOBS), "--no-report"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        wait_until(lambda: lines(out) > 60 or process.poll() is not None)
        process.send_signal(how)
        _, told = process.communicate(timeout=60)
    known = lines(out)
    assert 60 < known < count, "it was ended on its way"
    if how == signal.SIGKILL:
        assert process.returncode == -signal.SIGKILL
    else:
        assert process.returncode == {signal.SIGINT: 130, signal.SIGTERM: 143}[how]
        assert "interrupted; continue by: " in told
        assert told.rstrip().endswith(f"--out {out} --resume")
    rows = (out / "cases.jsonl").read_bytes().splitlines()[:known]
    numbers = {int(json.loads(row)["key"]) for row in rows}
    assert len(numbers) == known
    assert max(numbers) <= known - 1 + JOBS, "at most the candidates under evaluation are lost"
    done = cdpr_here("design", path, "--out", out, "--resume", "--no-report")
    assert "candidates satisfy all constraints" in done.stdout
    assert kept(out) == kept(tmp_path / "whole")


@pytest.mark.slow
def test_two_at_work_in_one_folder(tmp_path):
    path = write_design(tmp_path, optimizer="evaluations: 4000")
    out = tmp_path / "out"
    command = [sys.executable, "-m", "cdpr", "design", str(path), "--out", str(out), "--no-report"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        try:
            wait_until(lambda: lines(out) > 5 or process.poll() is not None)
            done = cdpr_here("design", path, "--out", out, "--resume", code=8)
        finally:
            process.kill()
    assert "another cdpr design is at work there" in done.stderr
