"""Output redirection: stdout of a program that uses cdpr has only its own output."""

from __future__ import annotations

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
