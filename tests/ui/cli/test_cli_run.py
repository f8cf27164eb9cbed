"""`cdpr run` as a user sees it: output, files, exit codes."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest
from command_line import cdpr_here
from conftest import ROOT

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
SHORT = ["--set", "simulation.duration=0.05", "--no-report"]


def cdpr(*arguments, cwd, code=0, env=None):
    """Run the command line in a process of its own; every error is text, never a traceback."""
    done = subprocess.run(
        [sys.executable, "-m", "cdpr", *arguments],
        cwd=cwd,
        capture_output=True,
        text=True,
        env={**os.environ, **(env or {})},
        timeout=120,
    )
    assert "Traceback" not in done.stderr
    assert done.returncode == code, done.stderr
    return done


@pytest.mark.core
def test_it_prints_a_summary_and_the_folder_last(tmp_path):
    done = cdpr_here("run", CAROCA, "--set", "simulation.duration=0.05", cwd=tmp_path)
    assert "infeasible steps    0 of 51" in done.stdout
    folder = tmp_path / done.stdout.splitlines()[-1]
    assert folder.parent == tmp_path / "runs"
    assert sorted(path.name for path in folder.iterdir()) == ["log.mcap", "report.html", "run.json", "scenario.yaml"]
    told = json.loads((folder / "run.json").read_text())
    assert told["status"] == "finished"
    assert told["argv"][1:3] == ["run", CAROCA]


def test_commanded_tensions_of_length_winches_are_called_nominal(tmp_path):
    done = cdpr_here("run", "camera_robot", *SHORT, "--out", "here", cwd=tmp_path)
    lines = {line[:20].strip(): line[20:].strip() for line in done.stdout.splitlines()}
    tension = json.loads((tmp_path / "here" / "run.json").read_text())["summary"]["cable_tension_N"]
    assert lines["in the cables"] == f"min {tension['min']:.5g} N   max {tension['max']:.5g} N"
    assert lines["nominal tension"].startswith("min ")
    assert "tension" not in lines


@pytest.mark.core
def test_stdout_contains_only_json(tmp_path):
    done = cdpr_here("run", CAROCA, *SHORT, "--backend", "mujoco", "--out", "here", "--json", cwd=tmp_path)
    figures = json.loads(done.stdout)
    assert figures["status"] == "finished"
    assert figures["samples"] == 51
    assert figures["folder"] == "here"
    assert 0 < figures["position_error_m"]["max"] < 1e-3
    assert figures["tension_N"]["min"] > 50


@pytest.mark.slow
def test_the_resolved_scenario_runs_to_the_same_bits(tmp_path):
    cdpr_here("run", CAROCA, *SHORT, "--out", "a", cwd=tmp_path)
    cdpr("run", "a/scenario.yaml", "--no-report", "--out", "b", cwd=tmp_path)
    assert (tmp_path / "a/log.mcap").read_bytes() == (tmp_path / "b/log.mcap").read_bytes()


def test_keys_that_the_run_does_not_use_are_reported(tmp_path):
    done = cdpr_here("run", CAROCA, *SHORT, "--set", "robot.cables[0].linear_density=0.05", cwd=tmp_path)
    assert "not used by this run: robot.cables[*].linear_density" in done.stdout


def test_a_taken_folder_is_refused(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years of work")
    done = cdpr_here("run", CAROCA, *SHORT, "--out", "mine", cwd=tmp_path, code=8)
    assert "mine" in done.stderr
    assert (tmp_path / "mine" / "thesis.tex").read_text() == "years of work"


@pytest.mark.core
@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["nowhere.yaml"], 2, "nowhere.yaml"),
        ([CAROCA, "--set", "simulation.duration=-1"], 2, "--set simulation.duration=-1"),
        ([CAROCA, "--backend", "mujuco"], 3, "did you mean 'mujoco'?"),
        ([CAROCA, "--no-such-option"], 2, "no-such-option"),
        ([CAROCA, *SHORT, "--set", "robot.tension.max=200", "--set", "solver.infeasible=stop"], 4, "stopped: t = 0 s"),
        ([CAROCA, "--no-report", "--set", "robot.tension.max=1e9", "--set", "controller.kp=1e6",
          "--set", "controller.kd=1e5", "--set", "initial.position=[0.1, 0, 1.2]"], 5, "stopped: t = "),
    ],
)  # fmt: skip
def test_exit_codes(arguments, code, text, tmp_path):
    done = cdpr_here("run", *arguments, cwd=tmp_path, code=code)
    assert text in done.stderr


@pytest.mark.slow
def test_a_run_needs_no_matplotlib(tmp_path):
    (tmp_path / "matplotlib.py").write_text("raise ImportError('blocked')")
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep)
    done = cdpr("run", CAROCA, "--set", "simulation.duration=0.05", cwd=tmp_path, env={"PYTHONPATH": path})
    assert "matplotlib" not in done.stderr
    (report,) = tmp_path.glob("runs/*/report.html")
    assert 'role="img" aria-label="Cable tensions"' in report.read_text()


def test_python_writes_no_files_by_default(tmp_path, monkeypatch):
    import cdpr as package

    monkeypatch.chdir(tmp_path)
    run = package.simulate(CAROCA, backend="mujoco", overrides={"simulation.duration": 0.05}, out=None)
    assert list(tmp_path.iterdir()) == []
    assert run.time.shape == (51,)
    assert run.position.shape == (51, 3)
    assert run.tension.shape == (51, 8)
    assert run.plot().axes


def test_real_time_is_no_faster_than_the_clock():
    from time import monotonic

    import cdpr as package

    begun = monotonic()
    package.simulate(CAROCA, overrides={"simulation.duration": 0.3}, real_time=True)
    assert monotonic() - begun >= 0.299


@pytest.mark.slow
def test_a_run_imports_nothing_slow_that_it_does_not_need(tmp_path):
    slow = ("scipy", "matplotlib", "mujoco", "rich", "numpy.ma", "cdpr.analysis.workspace", "cdpr.ui.report.pages")
    code = (
        "import atexit, sys; from cdpr.ui.cli import main;"
        f"atexit.register(lambda: print([*{set(slow)!r} & set(sys.modules)], file=sys.stderr)); main()"
    )
    words = ["run", str(CAROCA), "--set", "simulation.duration=0.02", "--no-report", "--out", str(tmp_path / "run")]
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=True)
    assert done.stderr.endswith("[]\n")
