"""Runs that are interrupted, terminated or killed."""

from __future__ import annotations

import json
import os
import signal
import struct
import subprocess
import sys
import time
import warnings

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.base.errors import Interrupted
from cdpr.log.blocks import BLOCK
from cdpr.log.chunk_file import QUEUE
from cdpr.log.files import Reserved
from cdpr.log.run_folder import RunFolder
from cdpr.log.writer import LogWriter
from cdpr_controllers.computed_torque import ComputedTorque

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
ROWS_LOST = BLOCK * (1 + QUEUE)  # a block that was not full yet and those that wait for the thread, in a fast run ...
SECONDS_LOST = 0.5  # ... and wall time while it is slow
SLACK = 0.1  # s, of the scheduler

# A run that keeps the number of the present step in a mapped file, where it survives a SIGKILL.
COUNTED = """
import mmap, struct, sys
import cdpr
from cdpr_controllers import ComputedTorqueOptions
from cdpr_controllers.computed_torque import ComputedTorque

file = open(sys.argv[1], "r+b")
counter = mmap.mmap(file.fileno(), 8)
steps = -1  # the warm-up is none

class Counted(ComputedTorque):
    Options = ComputedTorqueOptions

    def control(self, *arguments):
        global steps
        steps += 1
        counter[:8] = struct.pack("q", steps)
        super().control(*arguments)

overrides = {"simulation.duration": 3600.0, "simulation.control_step": float(sys.argv[4])}
real_time = sys.argv[5] == "real-time"
cdpr.simulate(sys.argv[2], controller=Counted, out=sys.argv[3], overrides=overrides, real_time=real_time)
"""


def wait_for_rows(process, folder):
    log = folder / "log.mcap"
    deadline = time.monotonic() + 120
    while not (log.exists() and log.stat().st_size > 20_000):
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < deadline
        time.sleep(0.005)


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 143)])
def test_a_stopped_run_is_closed_and_reported(number, code, tmp_path):
    command = [sys.executable, "-m", "cdpr", "run", CAROCA, "--no-report", "--out", str(tmp_path / "run")]
    process = subprocess.Popen(
        [*command, "--set", "simulation.duration=3600"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),  # the tests may run under nohup
    )
    wait_for_rows(process, tmp_path / "run")
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
    assert len(run.rows) > 10


@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize(
    "what", [(LogWriter, "close"), (RunFolder, "finish"), (Reserved, "write"), (ComputedTorque, "close")]
)
def test_a_second_signal_cuts_nothing_short(what, after, tmp_path, monkeypatch):
    """Any interrupted file is computed again, with the same result."""
    owner, name = what
    method, calls = getattr(owner, name), []

    def interrupted(*arguments):
        calls.append(None)
        if len(calls) == 1 and not after:
            raise KeyboardInterrupt
        found = method(*arguments)
        if len(calls) == 1:
            raise KeyboardInterrupt
        return found

    def first(done, total):
        if done:
            raise Interrupted("interrupted")

    monkeypatch.setattr(owner, name, interrupted)
    overrides = {"simulation.duration": 0.6}
    with pytest.raises(Interrupted) as caught:
        cdpr.simulate(CAROCA, overrides=overrides, out=tmp_path / "run", progress=first)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = cdpr.load_run(tmp_path / "run")
    assert run.status == caught.value.run.status == "interrupted"
    np.testing.assert_array_equal(run.rows, caught.value.run.rows)
    assert len(run.rows) == 256
    assert sorted(os.listdir(tmp_path / "run")) == ["log.mcap", "run.json", "scenario.yaml"]


def killed(tmp_path, moment, *, step=1e-3, pace="fast"):
    """Kill a run some time after its first rows; return its folder and the number of steps that it had made."""
    folder, counter = tmp_path / "run", tmp_path / "counter"
    counter.write_bytes(bytes(8))
    process = subprocess.Popen(
        [sys.executable, "-c", COUNTED, counter, CAROCA, folder, str(step), pace], stderr=subprocess.PIPE, text=True
    )
    wait_for_rows(process, folder)
    time.sleep(moment)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    return folder, struct.unpack("q", counter.read_bytes())[0]


def assert_opens_after_repair(folder, steps, lost):
    assert json.loads((folder / "run.json").read_text())["status"] == "running"
    with pytest.warns(UserWarning, match="cdpr repair"):
        torn = cdpr.load_run(folder)
    subprocess.run([sys.executable, "-m", "cdpr", "repair", str(folder)], check=True, capture_output=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = cdpr.load_run(folder)
    assert run.status == "interrupted"
    np.testing.assert_array_equal(run.rows, torn.rows)
    assert steps - lost <= len(run.rows) <= steps
    # Existing results are right: the same as of an uninterrupted run.
    step = run.header.control_step
    whole = cdpr.simulate(
        CAROCA, overrides={"simulation.duration": (len(run.rows) - 1) * step, "simulation.control_step": step}
    )
    np.testing.assert_array_equal(run.rows, whole.rows)


@pytest.mark.slow
def test_a_killed_run_opens_after_repair(tmp_path):
    assert_opens_after_repair(*killed(tmp_path, 0.13), ROWS_LOST)


@pytest.mark.slow
def test_in_real_time_half_a_second_is_lost_at_most(tmp_path):
    step = 0.01
    folder, steps = killed(tmp_path, 1.3, step=step, pace="real-time")
    assert_opens_after_repair(folder, steps, (SECONDS_LOST + SLACK) / step)


@pytest.mark.slow
@pytest.mark.parametrize("moment", np.random.default_rng(2).uniform(0, 1.0, 10))
def test_ten_kills(tmp_path, moment):
    assert_opens_after_repair(*killed(tmp_path, moment), ROWS_LOST)
