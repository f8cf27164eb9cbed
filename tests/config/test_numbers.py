"""Numbers in messages are those that were given; what no robot reaches is refused."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest
from conftest import ROOT

from cdpr.base.errors import ExitCode, OutputError, ScenarioError
from cdpr.scenario import load_scenario
from cdpr.simulation import simulate

CAROCA = ROOT / "scenarios" / "caroca.yaml"


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"simulation.duration": 1.0000001}, "control_step, 0.001 (s), got 1.0000001;"),
        ({"robot.tension.min": 1e3 + 1e-9, "robot.tension.max": 1e3}, "1000 (N), got 1000.000000001"),
        ({"simulation.control_step": 0.01, "simulation.physics_step": 0.0030000001}, "got 0.0030000001;"),
    ],
)
def test_numbers_are_reported_with_all_their_digits(changes, text):
    with pytest.raises(ScenarioError) as caught:
        load_scenario(CAROCA, overrides=changes)
    assert text in str(caught.value)


@pytest.mark.parametrize(
    "key",
    ["initial.position[1]", "trajectory.to.position[0]", "robot.cables[0].frame[2]", "robot.cables[0].platform[2]"],
)
def test_a_position_that_no_robot_reaches_is_refused(key):
    with pytest.raises(ScenarioError, match=r"must lie between -1e\+06 and 1e\+06 \(m\), got 1000000000"):
        load_scenario(CAROCA, overrides={key: 1e9})


def test_a_run_that_can_never_fit_is_refused_at_its_line_before_its_folder_is_made(tmp_path, monkeypatch):
    monkeypatch.setattr("cdpr.simulation.disk_space.FLOAT", 1e9)
    with pytest.raises(
        ScenarioError, match=r"caroca.yaml:\d+:\d+: simulation.duration: \d+ samples need .* GB, the mem"
    ):
        simulate(CAROCA)
    monkeypatch.setattr("shutil.disk_usage", lambda path: type("Usage", (), {"free": 1000, "total": 9000}))
    with pytest.raises(
        ScenarioError, match=r"simulation.duration: \d+ samples need at least .* kB, the disk of .*/a/run has 1 kB"
    ):
        simulate(CAROCA, out=tmp_path / "a" / "run")
    monkeypatch.setattr("shutil.disk_usage", lambda path: type("Usage", (), {"free": 1000, "total": 10**12}))
    with pytest.raises(OutputError, match=r"has 1 kB: shorten it .*, or make room there") as full:  # it would fit there
        simulate(CAROCA, out=tmp_path / "a" / "run")
    assert full.value.exit_code == ExitCode.NOT_WRITABLE
    assert not list(tmp_path.iterdir())
    monkeypatch.setattr("shutil.disk_usage", lambda path: type("Usage", (), {"free": 0, "total": 0}))
    short = {"simulation.duration": 0.01}
    assert simulate(CAROCA, overrides=short, out=tmp_path / "run").status == "finished"  # no disk to speak of


def test_a_folder_below_one_that_may_not_be_searched_is_refused(tmp_path, monkeypatch):
    """As its stat answers any user but root."""
    real = Path.stat

    def stat(path, **more):
        if path.is_relative_to(tmp_path / "closed" / "runs"):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        return real(path, **more)

    monkeypatch.setattr(Path, "stat", stat)
    with pytest.raises(OutputError, match="closed/runs/one: cannot be written: Permission denied"):
        simulate(CAROCA, out=tmp_path / "closed" / "runs" / "one")
