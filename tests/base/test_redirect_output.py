"""Output redirection: stdout of a program that uses cdpr has only its own output."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from conftest import ROOT

from cdpr.plugins.registry import registry

SOLVE = f"""
import numpy as np
from cdpr.plugins.registry import registry
from cdpr.scenario import load_robot
robot = load_robot({str(ROOT / "scenarios" / "robots" / "caroca.yaml")!r})
for name in registry().names("solver"):
    entry = registry().get("solver", name)
    if not entry.missing:
        entry.make(robot, entry.read_options({{}}))
"""


@pytest.mark.slow
@pytest.mark.skipif(bool(registry().get("solver", "highs").missing), reason="highspy is not installed")
def test_no_solver_prints_as_it_is_made():
    done = subprocess.run([sys.executable, "-c", SOLVE], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")


THREADS = """
import threading
from cdpr.base.redirect_output import discarded_output
inside, begun = threading.Event(), threading.Event()

def first():
    with discarded_output():
        inside.set()
        begun.wait(0.2)  # the second may not enter meanwhile

def second():
    inside.wait()
    with discarded_output():
        begun.set()
        one.join(0.2)

one, two = threading.Thread(target=first), threading.Thread(target=second)
one.start(), two.start()
one.join(), two.join()
print("still there")
"""


def test_threads_that_replace_stdout_at_once_leave_it_in_place():
    done = subprocess.run([sys.executable, "-c", THREADS], capture_output=True, text=True, check=True)
    assert done.stdout == "still there\n"


CLOSED = """
import os, sys
from cdpr.base.redirect_output import discarded_output
closed = [int(number) for number in sys.argv[2:]]
with discarded_output():
    os.write(1, b"discarded")
    os.write(2, b"discarded")
for fd in range(3):
    try:
        os.fstat(fd)
        assert fd not in closed, fd
    except OSError:
        assert fd in closed, fd
open(sys.argv[1], "w").write("done")
"""


@pytest.mark.parametrize("closed", [(1,), (2,), (1, 2), (0, 1, 2)], ids=str)
def test_closed_streams_are_closed_again(tmp_path, closed):
    """As with `cdpr ... >&-` in a shell."""
    done = run_without(closed, "-c", CLOSED, str(tmp_path / "result"), *map(str, closed))
    assert (tmp_path / "result").exists(), done.stderr
    assert b"discarded" not in done.stdout + done.stderr


FIRST_FILE = """
import sys
from cdpr.ui.cli.streams import streams
with streams(), open(sys.argv[1], "w") as file:
    file.write(str(file.fileno()))
"""


@pytest.mark.parametrize("closed", [(1,), (0, 1, 2)], ids=str)
def test_no_file_of_a_command_gets_the_number_of_a_closed_stream(tmp_path, closed):
    """Otherwise the output of native code would go to that file."""
    run_without(closed, "-c", FIRST_FILE, str(tmp_path / "file"))
    assert int((tmp_path / "file").read_text()) > 2


CHILD = """
import os, sys
from cdpr.base.redirect_output import open_closed_streams
open_closed_streams()
open(sys.argv[1], "w").write(str([os.get_inheritable(fd) for fd in range(3)]))
"""


@pytest.mark.parametrize("closed", [(0,), (1,), (2,), (0, 1, 2)], ids=str)
def test_child_processes_inherit_the_streams_in_place_of_closed_ones(tmp_path, closed):
    run_without(closed, "-c", CHILD, str(tmp_path / "result"))
    assert (tmp_path / "result").read_text() == "[True, True, True]"


@pytest.mark.slow
@pytest.mark.skipif(bool(registry().get("backend", "bullet").missing), reason="pybullet is not installed")
def test_a_run_on_bullet_without_streams(tmp_path):
    run = ["-m", "cdpr", "run", "caroca", "--backend", "bullet", "--set", "simulation.duration=0.01"]
    assert run_without((0, 1, 2), *run, "--out", str(tmp_path / "run")).returncode == 0


def run_without(closed, *arguments):
    """Run Python with some of the standard streams closed."""

    def close():
        for fd in closed:
            os.close(fd)

    return subprocess.run([sys.executable, *arguments], capture_output=True, preexec_fn=close, check=False)
