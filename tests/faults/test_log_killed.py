"""Logs of runs that are killed: what was flushed is there, whichever byte was written last."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT
from log_cases import make_header, make_rows, same_bits, write_log
from spread import sampled

from cdpr.log.blocks import BLOCK
from cdpr.log.chunk import CHUNK_HEAD
from cdpr.log.reader import load_run, scan
from cdpr.log.repair import repair
from cdpr.log.writer import LogWriter
from cdpr.model.robot import Array

HEADER = make_header(2)
ROWS = make_rows(HEADER, 2 * BLOCK + 44)

CHILD = """
import sys, time
from pathlib import Path
sys.path.insert(0, {tests!r})
from log_cases import make_header, make_rows
from cdpr.log.blocks import BLOCK
from cdpr.log.recorder import Recorder
from cdpr.log.run import Run
from cdpr.log.run_folder import RunFolder
header = make_header(2)
rows = make_rows(header, 40 * BLOCK)
folder = RunFolder(Path({out!r}), header)
recorder = Recorder(header, len(rows), folder.path)
recorder.rows[:-1] = rows
print("ready", flush=True)
for n in range(50, len(rows), 50):
    recorder.flush(n)
    print(n, flush=True)
"""


@sampled(1, "number", [3, 77])
def test_a_killed_run_loses_nothing_that_was_flushed(tmp_path: Path, number: int) -> None:
    tests = str(ROOT / "tests" / "support")
    script = CHILD.format(tests=tests, out=str(tmp_path / "run"))
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        lines = [child.stdout.readline() for _ in range(number)]
        child.send_signal(signal.SIGKILL)
    flushed = int(lines[-1])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = load_run(tmp_path / "run")
    assert run.status == "running"
    assert len(run.rows) >= flushed
    truth: Array = make_rows(make_header(2), 40 * BLOCK)
    assert same_bits(run.rows, truth[: len(run.rows)])


KILLS = int(os.environ.get("CDPR_KILLS", "2"))
AT_FULL_SPEED = CHILD.replace("range(50, len(rows), 50)", "range(BLOCK, len(rows), BLOCK)").replace("40 *", "100 *")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(KILLS))
def test_killed_at_any_moment_a_run_is_repaired_to_a_whole_log(tmp_path: Path, seed: int) -> None:
    """The writing thread is killed during a write; CDPR_KILLS sets the number of repetitions."""
    rng = np.random.default_rng(seed)
    script = CHILD if seed % 3 == 0 else AT_FULL_SPEED
    script = script.format(tests=str(ROOT / "tests" / "support"), out=str(tmp_path / "run"))
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        while child.stdout.readline() != "ready\n":
            assert child.poll() is None
        time.sleep(rng.uniform(0.0, 0.1))
        child.send_signal(signal.SIGKILL)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        kept = load_run(tmp_path / "run").rows[:]
    truth = make_rows(HEADER, 40 * BLOCK if seed % 3 == 0 else 100 * BLOCK)[: len(kept)]
    assert same_bits(kept, truth)
    assert repair(tmp_path / "run").rows == len(kept)
    assert (tmp_path / "run" / "log.mcap").read_bytes() == write_log(tmp_path / "whole", HEADER, truth).read_bytes()


class Mortal(io.FileIO):
    """A file whose process is killed after this number of further bytes."""

    left = sys.maxsize

    def write(self, data):
        done = super().write(memoryview(data)[: self.left])
        self.left -= done
        if not self.left:
            raise KeyboardInterrupt
        return done


def test_killed_within_a_write_what_was_flushed_before_stays(tmp_path: Path) -> None:
    """A block that was begun is written anew as a longer one; killed at any byte of that."""
    path = tmp_path / "log.mcap"
    for left in (1, 20, CHUNK_HEAD.size - 1, 1000, 30_000, 60_000):
        writer = LogWriter(path, HEADER)
        writer.write(ROWS, 100)
        whole = path.stat().st_size
        for stop, flushed in ((150, 100), (BLOCK + 10, 150)):
            file = Mortal(writer.out.file.fileno(), "r+b", closefd=False)
            file.left = left
            writer.out.file, kept = file, writer.out.file
            with pytest.raises(KeyboardInterrupt):
                writer.write(ROWS, stop)
            found = scan(path)
            assert len(found.rows) >= flushed, (left, stop)
            assert same_bits(found.rows, ROWS[: len(found.rows)])
            writer.out.file = kept
            writer.write(ROWS, 150)
        writer.out.close()
        assert path.stat().st_size > whole
