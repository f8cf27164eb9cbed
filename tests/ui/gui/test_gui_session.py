"""Runs and sessions that the window saves: what is written, where, and that it repeats."""

from __future__ import annotations

import time
from threading import Event

import pytest
from conftest import ROOT
from driver_cases import PATIENCE, running_driver, scenario, until, wait
from plants import installed

import cdpr
from cdpr.scenario import load_scenario


@pytest.fixture
def no_report(monkeypatch):
    """Drawing a report takes a second."""
    monkeypatch.setattr("cdpr.ui.report.pages.run.write_report", lambda run, path, **_: path.touch())


@pytest.mark.slow
def test_runs_too_long_for_the_memory_go_to_a_folder_that_is_gone_in_the_end(tmp_path, monkeypatch, no_report):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    long = scenario(**{"simulation.duration": 120.0})
    with running_driver(long) as it:
        it.phase("ready")
        assert len(list(tmp_path.glob("cdpr-gui-*/log.mcap"))) == 1
        it.do("step", n=5000)
        it.do("save_run", out=str(tmp_path / "run"))
        it.do("step", n=100)
        it.do("reset")
        it.do("step", n=10)
        until((tmp_path / "run" / "report.html").exists)
        assert [level for level, _ in it.said() if level == "error"] == []
    assert list(tmp_path.glob("cdpr-gui-*")) == []
    saved = cdpr.load_run(tmp_path / "run")
    same = cdpr.simulate(scenario(**{"simulation.duration": 5.0}))
    assert saved.rows[:].tobytes() == same.rows[:5000].tobytes()


def test_a_run_is_saved_as_it_would_have_logged(tmp_path):
    with running_driver(scenario()) as it:
        it.phase("ready")
        it.do("step", n=50)
        it.do("save_run", out=str(tmp_path / "half"))
        it.do("speed", value=None)
        it.do("run")
        it.phase("done")
        it.do("save_run", out=str(tmp_path / "whole"))
        it.do("save_run", out=str(tmp_path / "whole"))
        until(lambda: len(it.told) == 3)
        assert sorted(level for level, _ in it.said()) == ["error", "info", "info"]
    cdpr.simulate(scenario(), out=tmp_path / "logged")
    assert (tmp_path / "whole" / "log.mcap").read_bytes() == (tmp_path / "logged" / "log.mcap").read_bytes()
    assert (tmp_path / "whole" / "report.html").stat().st_size > 50_000
    half, whole = cdpr.load_run(tmp_path / "half"), cdpr.load_run(tmp_path / "whole")
    assert (half.status, whole.status) == ("ended", "finished")
    assert half.rows.tobytes() == whole.rows[:50].tobytes()
    assert half.summary()["samples"] == 50
    assert not (tmp_path / "whole" / "session.yaml").exists()


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
@pytest.mark.usual("reference")
def test_a_session_repeats_to_the_bit(backend, tmp_path, no_report):
    """Actions of a user during a real-time run, at any samples."""
    live = scenario(**{"simulation.backend": backend, "simulation.duration": 5.0})  # no end while something compiles
    with running_driver(live) as it:
        it.phase("ready")
        it.do("run")
        wait(it.broadcast, "frame", lambda frame: frame["t"] > 0.03)
        it.do("push", force=[100, 0, 20], duration=0.05)
        it.do("target", position=[1.0, 0.32, 1.5], duration=0.1)
        wait(it.broadcast, "frame", lambda frame: frame["t"] > 0.1)
        it.do("set", key="controller.kp", value=30)
        it.do("cut", cable=2)
        it.do("speed", value=None)
        it.phase("done")
        it.do("save_session", out=str(tmp_path / "session.yaml"))
        it.do("save_run", out=str(tmp_path / "run"))
        until(lambda: len(it.told) == 2)
        told = it.said()
        assert [level for level, _ in told] == ["info", "info"], told
    rows = cdpr.load_run(tmp_path / "run").rows.tobytes()
    assert cdpr.simulate(tmp_path / "session.yaml").rows.tobytes() == rows
    assert cdpr.simulate(tmp_path / "run" / "session.yaml").rows.tobytes() == rows


def test_jogs_are_shown_and_repeat_to_the_bit(tmp_path, no_report):
    live = load_scenario(ROOT / "scenarios" / "camera_robot.yaml", overrides={"simulation.duration": 0.3})
    with running_driver(live) as it:
        it.phase("ready")
        status = wait(it.broadcast, "status")
        assert [winch["takes"] for winch in status["winches"]] == ["length"] * 4
        assert not status["manual"]
        it.do("step", n=10)
        it.do("jog", cable="cable_2", rate=0.05)
        it.do("step", n=50)
        assert it.said() == []
        jogged = it.broadcast.latest("status")
        assert jogged["manual"]
        it.do("hold")
        it.do("step", n=5)
        it.do("control")
        it.do("speed", value=None)
        it.do("run")
        assert not it.phase("done")["manual"]
        it.do("save_run", out=str(tmp_path / "run"))
        until(lambda: it.told)
    run = cdpr.load_run(tmp_path / "run")
    command = run["winch_command"][:, 1]
    assert command[59] - command[9] == pytest.approx(50 * 0.05 * 0.002, abs=1e-12)
    assert command[59:65].tolist() == [command[59]] * 6
    assert jogged["winches"][1]["unwound"] == round(run["unstretched_length"][59, 1], 6)
    assert cdpr.simulate(tmp_path / "run" / "session.yaml").rows.tobytes() == run.rows.tobytes()


@pytest.mark.slow
def test_a_saved_session_takes_the_place_of_nothing_but_itself(tmp_path):
    mine, session = tmp_path / "mine.yaml", tmp_path / "session.yaml"
    mine.write_text("# hours of work\n")
    (tmp_path / "given_outside.csv").write_text("t\n")
    with running_driver(scenario()) as it:
        it.phase("ready")
        it.do("step", n=2)
        for out in (mine, tmp_path / "given.yaml", session):
            it.do("save_session", out=str(out))
        it.do("step", n=3)
        it.do("save_session", out=str(session))
        told = it.said()
        it.do("reset")
        it.do("step")
        it.do("save_session", out=str(session))
        assert "already exists" in it.said()[-1][1]
    assert [level for level, _ in told] == ["error", "error", "info", "info"]
    assert "mine.yaml' already exists and is not overwritten" in told[0][1]
    assert "given_outside.csv' already exists" in told[1][1]
    assert mine.read_text() == "# hours of work\n"
    assert not (tmp_path / "given.yaml").exists()
    assert load_scenario(session).simulation.steps == 4


def test_started_writes_are_completed(tmp_path, monkeypatch):
    begun, written = Event(), []

    def report(run, folder, touch):
        begun.set()
        time.sleep(0.2)
        written.append(folder)
        return ""

    monkeypatch.setattr("cdpr.ui.gui.session._report", report)
    with running_driver(scenario()) as it:
        it.phase("ready")
        it.do("step", n=3)
        it.do("save_run", out=str(tmp_path / "run"))
        assert begun.wait(PATIENCE)
    assert written == [tmp_path / "run"]
