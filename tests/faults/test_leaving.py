"""The command line ends while a thread is in the midst of an engine that does not come back."""

from __future__ import annotations

import subprocess
import sys
import textwrap

import pytest
from conftest import ROOT

CODE = """
import sys, threading, cdpr.ui.cli
from cdpr.ui.gui.broadcast import Broadcast
from cdpr.ui.gui.driver import WindowDriver
from cdpr.scenario import load_scenario
from cdpr.simulation.requests import Request

at_work = threading.Event()


class Endless:
    def close(self):
        with cdpr.Simulation(sys.argv[1], backend="mujoco", overrides={"simulation.duration": 1e4}) as sim:
            while True:
                sim.step(100)
                at_work.set()


driver = WindowDriver(Broadcast(), print)
assert hasattr(driver, "_session")


def leave_endless():
    driver._session = Endless()  # in the driver's own thread, which would otherwise publish it first
    driver._leave()


driver.requests.put(Request("close", action=leave_endless))
assert at_work.wait(60.0)
driver.close()
print("last words", end="")
cdpr.ui.cli._leave(5)
"""


@pytest.mark.slow
def test_a_thread_that_does_not_end_does_not_crash_the_end():
    pytest.importorskip("mujoco")
    pytest.importorskip("websockets", reason="websockets is not installed: pip install 'cdpr[gui]'")
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(CODE), ROOT / "scenarios" / "caroca.yaml"],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert (done.returncode, done.stdout, done.stderr) == (5, "last words", "")


UNCLOSED = """
import sys, cdpr.ui.cli

class Plugin:  # in a circle, as what is bound to itself is
    def __init__(self):
        self.file = open(sys.argv[1], "w")
        self.write = self.file.write
        self.me = self

Plugin().write("rows")
sys.argv[1:] = ["--version"]
cdpr.ui.cli.main()
"""


def test_open_files_of_plugins_are_flushed(tmp_path):
    subprocess.run([sys.executable, "-c", UNCLOSED, tmp_path / "rows.txt"], check=True)
    assert (tmp_path / "rows.txt").read_text() == "rows"
