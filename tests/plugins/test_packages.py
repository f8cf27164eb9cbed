"""Two third-party packages: installed, found, checked with the kit and used in a run."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT
from docs_cases import INSTALLED, commands, make_folder, shorter, words

HERE = ROOT / "tests" / "plugins"
SOLVER = HERE / "weighted_solver"
TUTORIAL = (ROOT / "docs" / "plugins.md").read_text()
CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
SHORT = ["--set", "simulation.duration=0.1", "--no-report", "--json"]


def pip_install(target, *options):
    """Install both packages into a folder; no network, nothing else is touched."""
    packages = [SOLVER, HERE / "drag_backend"]
    offline = ["--no-deps", "--no-build-isolation", "--no-index", "--quiet", "--disable-pip-version-check"]
    subprocess.run([sys.executable, "-m", "pip", *options, "install", *offline, *target, *packages], check=True)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """An environment variable set in which both are installed."""
    folder = tmp_path_factory.mktemp("site")
    pip_install(["--target", folder])
    path = os.pathsep.join([str(folder), str(ROOT), os.environ.get("PYTHONPATH", "")])
    return [sys.executable], {**os.environ, "PYTHONPATH": path}


def run(command, *arguments, cwd, code=0):
    program, env = command
    done = subprocess.run([*program, *arguments], env=env, cwd=cwd, capture_output=True, text=True, timeout=300)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout


def use(command, tmp_path):
    """All that a user does with the two."""
    listed = json.loads(run(command, "-m", "cdpr", "plugins", "--json", cwd=tmp_path))
    assert listed["problems"] == []
    assert {"weighted", "drag"} <= {row["name"] for row in listed["solvers"] + listed["backends"]}
    checks = json.loads(run(command, "-m", "cdpr", "check", "backend", "drag", "--json", cwd=tmp_path))["checks"]
    assert {check["outcome"] for check in checks} == {"passed", "n/a"}
    few = ["--solvers", "qp,weighted", "--poses", "20", "--adversaries", "20", "--json"]
    compared = json.loads(run(command, "-m", "cdpr", "bench", "solvers", "planar", *few, cwd=tmp_path))
    rows = {row["solver"]: row for row in compared["robots"][0]["results"]}
    assert rows["weighted"]["outcome"] == "measured"
    assert rows["weighted"]["worst_residual"] < 1e-12
    choice = ["--backend", "drag", "--solver", "weighted", "--set", "backend_options.drag.area=0.5"]
    told = json.loads(run(command, "-m", "cdpr", "run", CAROCA, *choice, *SHORT, "--out", "run", cwd=tmp_path))
    assert told["status"] == "finished"


@pytest.mark.slow
def test_installed_beside(installed, tmp_path):
    use(installed, tmp_path)


@pytest.mark.slow
def test_their_own_test_file(installed, tmp_path):
    """The code of the tutorial runs under pytest, one test per check."""
    shutil.copy(SOLVER / "test_weighted.py", tmp_path)
    said = run(installed, "-m", "pytest", "-q", cwd=tmp_path)
    assert re.search(r"\d+ passed, \d+ skipped", said)


@pytest.mark.slow
def test_drag_slows(installed, tmp_path):
    """The option has its documented effect: quadratic drag has the closed form v0 / (1 + k v0 t)."""
    program = """
import numpy as np
from cdpr.testing import samples
from cdpr_drag import DragOptions
from cdpr_drag.backend import DragBackend
backend = DragBackend(samples.ball(), np.zeros(3), 1e-4, DragOptions(area=2.0))
backend.reset(np.array([0, 0, 2, 1, 0, 0, 0, 3, 0, 0, 0, 0, 0.0]))
backend.step(10_000)
assert abs(backend.state[7] - 3.0 / (1 + 0.5 * 1.2 * 2.0 / 2.0 * 3.0)) < 1e-3, backend.state
"""
    run(installed, "-c", program, cwd=tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("command", [*filter(INSTALLED.search, commands(TUTORIAL))])
def test_commands_of_the_tutorial(installed, tmp_path, command):
    make_folder(tmp_path)
    run(installed, "-m", "cdpr", *words(command), *shorter(command), cwd=tmp_path)


@pytest.mark.slow
def test_installed_into_a_fresh_environment(tmp_path):
    """pip install into a new venv outside the tree, which finds our dependencies where this one has them."""
    venv = tmp_path / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", venv], check=True)
    python = venv / "bin" / "python"
    (site,) = (venv / "lib").glob("python*/site-packages")
    inherited = [path for path in sys.path if path.endswith("site-packages")]
    (site / "dependencies.pth").write_text("\n".join([str(ROOT), *inherited]) + "\n")
    pip_install([], "--python", python)
    env = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    use(([str(python)], env), tmp_path)


@pytest.mark.parametrize(
    "file",
    ["pyproject.toml", "cdpr_weighted/__init__.py", "cdpr_weighted/solver.py", "test_weighted.py"],
)
def test_tutorial_shows_the_package_word_for_word(file):
    blocks = dict(re.findall(r"^`([\w./]+)`:\n\n```\w+\n(.*?)^```$", TUTORIAL, re.DOTALL | re.MULTILINE))
    assert blocks[file] == (SOLVER / file).read_text()


def test_the_solver_has_less_than_thirty_lines_of_code():
    """Without blank lines and docstrings."""
    lines = 0
    for file in ("__init__.py", "solver.py"):
        text = re.sub(r'"""[^"]*"""', "", (SOLVER / "cdpr_weighted" / file).read_text())
        lines += sum(bool(line.strip()) for line in text.splitlines())
    assert lines < 30, lines


def test_every_check_is_documented():
    from cdpr.testing.kit import BACKEND, CONTROLLER, SOLVER

    page = (ROOT / "docs" / "plugin_checks.md").read_text()
    missing = [check.id for check in [*BACKEND, *SOLVER, *CONTROLLER] if f"`{check.id}`" not in page]
    assert missing == []
