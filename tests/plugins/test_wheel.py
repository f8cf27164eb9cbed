"""What a user has who installs the wheel and has no checkout: the examples, by their names."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile

import pytest
from conftest import ROOT

BUILD = """
from hatchling.builders.wheel import WheelBuilder

print(*WheelBuilder({!r}).build(directory={!r}, versions=["standard"]))
"""
WITHOUT_MATPLOTLIB = "import sys; sys.modules['matplotlib'] = None; from cdpr.cli import main; main()"


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """The Python of a new environment that holds the wheel, and finds our dependencies where this one has them."""
    folder = tmp_path_factory.mktemp("wheel")
    build = BUILD.format(str(ROOT), str(folder))
    wheel = subprocess.run([sys.executable, "-c", build], capture_output=True, text=True, check=True).stdout.strip()
    venv = folder / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", venv], check=True)
    (site,) = (venv / "lib").glob("python*/site-packages")
    zipfile.ZipFile(wheel).extractall(site)
    inherited = [path for path in sys.path if path.endswith("site-packages")]
    (site / "dependencies.pth").write_text("\n".join(inherited) + "\n")
    return venv / "bin" / "python", site


def run(python, *arguments, cwd, code=0):
    env = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run([python[0], *arguments], env=env, cwd=cwd, capture_output=True, text=True, timeout=300)
    assert done.returncode == code, done.stdout + done.stderr
    return done


SHORT = ["--set", "simulation.duration=0.01"]


@pytest.mark.slow
def test_the_first_command_needs_no_file(python, tmp_path):
    done = run(python, "-m", "cdpr", "run", "--backend", "dart", *SHORT, "--out", "out", cwd=tmp_path)
    assert "no scenario is given: this runs the example caroca" in done.stderr
    assert json.loads((tmp_path / "out" / "run.json").read_text())["header"]["backend"] == "dart"
    assert (tmp_path / "out" / "report.html").is_file()


@pytest.mark.slow
def test_without_what_draws_there_is_a_report_and_one_line_says_what_figures_for_papers_need(python, tmp_path):
    run(python, "-c", WITHOUT_MATPLOTLIB, "run", "caroca", *SHORT, "--out", "out", cwd=tmp_path)
    assert "<svg" in (tmp_path / "out" / "report.html").read_text()
    figure = ["--figure", "tension", "--out", "tension.pdf"]
    done = run(python, "-c", WITHOUT_MATPLOTLIB, "view", "out", *figure, cwd=tmp_path, code=3)
    (line,) = done.stderr.splitlines()
    assert "matplotlib" in line
    assert "pip install 'cdpr[plot]'" in line


def test_the_examples_of_the_wheel_are_those_of_the_tree(python, tmp_path):
    rows = json.loads(run(python, "-m", "cdpr", "examples", "--json", cwd=tmp_path).stdout)
    assert all(row["file"].startswith(str(python[1])) for row in rows)
    assert {os.path.relpath(row["file"], python[1] / "cdpr" / "examples") for row in rows} == {
        str(path.relative_to(ROOT / "scenarios")) for path in (ROOT / "scenarios").rglob("*.yaml")
    }


def test_the_wheel_holds_all_c(python):
    """Without which no FMU can be exported."""
    of_tree = {path.relative_to(ROOT) for path in (ROOT / "cdpr").rglob("*") if path.suffix in (".c", ".h")}
    assert len(of_tree) > 20
    assert {
        path.relative_to(python[1]) for path in (python[1] / "cdpr").rglob("*") if path.suffix in (".c", ".h")
    } == of_tree
