"""A fork of a process that writes a log neither hangs nor changes the run."""

from __future__ import annotations

import os
import signal

import pytest
from conftest import ROOT

import cdpr
from cdpr.base.errors import OutputError

PATIENCE = 20  # s until a child that hangs is ended
REFUSED, OTHER = 7, 8


@pytest.mark.parametrize("leaves", [False, True])
def test_a_fork_that_writes_or_leaves_ends_with_an_error(tmp_path, leaves):
    changes = {"simulation.duration": 1.0}
    scenario = str(ROOT / "scenarios" / "planar_point_mass.yaml")
    with cdpr.Simulation(scenario, overrides=changes, out=tmp_path / "run") as simulation:
        simulation.step(300)
        child = os.fork()
        if child == 0:
            signal.alarm(PATIENCE)
            code = OTHER
            try:
                if leaves:
                    simulation.close()
                else:
                    simulation.step(700)
            except OutputError:
                code = REFUSED
            finally:
                os._exit(code)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == REFUSED
        simulation.step(700)
    run = cdpr.load_run(tmp_path / "run")
    assert run.status == "finished"
    assert len(run.time) == 1001
