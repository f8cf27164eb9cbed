"""Runs that are interrupted, terminated or killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import warnings

import numpy as np
import pytest
from conftest import ROOT

import cdpr

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
ROWS_LOST = 256  # or what half a second of wall time makes, which in real time is more


def start(folder, *options):
    """A long run, returned once its log has rows."""
    command = [sys.executable, "-m", "cdpr", "run", CAROCA, "--no-report", "--out", str(folder), *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    log = folder / "log.mcap"
    deadline = time.monotonic() + 120
    while not (log.exists() and log.stat().st_size > 200_000):
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < deadline
        time.sleep(0.005)
    return process


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_stopped_run_is_closed_and_told(number, code, tmp_path):
    process = start(tmp_path / "run", "--set", "simulation.duration=3600")
    process.send_signal(number)
    output, errors = process.communicate(timeout=60)
    assert process.returncode == code
    assert "stopped: t = " in errors
    assert "Traceback" not in errors
    assert "interrupted" in output
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # the log is whole
        run = cdpr.load_run(tmp_path / "run")
    assert run.status == "interrupted"
    assert len(run.rows) > 100


def kill_and_repair(folder, moment):
    """Kill a run paced by the clock, so that it is known how far it was; check what the log still holds."""
    process = start(folder, "--set", "simulation.duration=3600")
    time.sleep(moment)
    size_before = (folder / "log.mcap").stat().st_size
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    assert json.loads((folder / "run.json").read_text())["status"] == "running"
    with pytest.warns(UserWarning, match="cdpr repair"):
        torn = cdpr.load_run(folder)
    subprocess.run([sys.executable, "-m", "cdpr", "repair", str(folder)], check=True, capture_output=True)
    run = cdpr.load_run(folder)
    assert run.status == "interrupted"
    np.testing.assert_array_equal(run.rows, torn.rows)
    expected = cdpr.simulate(CAROCA, overrides={"simulation.duration": (len(run.rows) - 1) * 1e-3})
    np.testing.assert_array_equal(run.rows, expected.rows)
    # Nothing that had reached the file before the kill is lost, but for one block at the most.
    row_bytes = size_before / len(run.rows)
    assert len(run.rows) * row_bytes >= size_before - ROWS_LOST * row_bytes
    return run


def test_a_killed_run_opens_after_repair(tmp_path):
    for i, moment in enumerate(np.random.default_rng(1).uniform(0, 0.3, 3)):
        kill_and_repair(tmp_path / str(i), moment)


@pytest.mark.slow
def test_twenty_kills(tmp_path):
    for i, moment in enumerate(np.random.default_rng(2).uniform(0, 1.0, 20)):
        kill_and_repair(tmp_path / str(i), moment)


def test_in_real_time_half_a_second_is_lost_at_most(tmp_path):
    """The clock tells how far the run was; the log must be there within half a second."""
    folder = tmp_path / "run"
    process = start(folder, "--set", "simulation.duration=3600", "--set", "simulation.control_step=0.01", "--real-time")
    # Row k is made at k * 10 ms after the first; the file's rows at two moments tell the clock's start.
    begun = time.monotonic()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        first = len(cdpr.load_run(folder).rows)
    time.sleep(1.3)
    os.kill(process.pid, signal.SIGKILL)
    passed = time.monotonic() - begun
    process.communicate()
    with pytest.warns(UserWarning, match="rows kept"):
        kept = len(cdpr.load_run(folder).rows)
    assert kept >= first + (passed - 0.5 - 0.1) / 0.01 - 50
