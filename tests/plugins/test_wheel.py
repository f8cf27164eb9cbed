"""Installed wheel without a checkout: the examples by their names, and the kernel library."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from conftest import ROOT
from offline import ONE_TARGET, has_compiler, pip

WITHOUT_MATPLOTLIB = "import sys; sys.modules['matplotlib'] = None; from cdpr.ui.cli import main; main()"


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """The Python of a new environment that holds the wheel, and finds our dependencies where this one has them.

    CDPR_TEST_WHEEL is a wheel that has been built already.
    """
    if "CDPR_TEST_WHEEL" in os.environ:
        return unpacked(tmp_path_factory.mktemp("wheel"), os.environ["CDPR_TEST_WHEEL"])
    if not has_compiler():
        pytest.skip("there is no C++ compiler, and building with zig takes too long here")
    folder = tmp_path_factory.mktemp("wheel")
    return unpacked(folder, built(folder, *ONE_TARGET))


def built(folder, *words, **more):
    assert "`pip wheel --no-deps .`" in (ROOT / "CONTRIBUTING.md").read_text()
    done = built_by_pip(folder, *words, **more)
    assert done.returncode == 0, done.stdout + done.stderr
    (wheel,) = folder.glob("cdpr-*-cp311-abi3-linux_*.whl")
    return wheel


def unpacked(folder, wheel):
    venv = folder / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", venv], check=True)
    (site,) = (venv / "lib").glob("python*/site-packages")
    zipfile.ZipFile(wheel).extractall(site)
    inherited = [path for path in sys.path if path.endswith("site-packages")]
    (site / "dependencies.pth").write_text("\n".join(inherited) + "\n")
    return venv / "bin" / "python", site


def built_by_pip(folder, *words, **more):
    """Run CONTRIBUTING's command without a network."""
    place = ["--config-settings", f"build-dir={folder / 'build'}"]
    return pip(folder, "wheel", *place, *words, "-w", folder, ROOT, **more)


def run(python, *arguments, cwd, code=0, **more):
    env = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | more
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
def test_without_matplotlib_the_report_works_and_a_line_names_the_extra(python, tmp_path):
    run(python, "-c", WITHOUT_MATPLOTLIB, "run", "caroca", *SHORT, "--out", "out", cwd=tmp_path)
    assert "<svg" in (tmp_path / "out" / "report.html").read_text()
    figure = ["--figure", "tension", "--out", "tension.pdf"]
    done = run(python, "-c", WITHOUT_MATPLOTLIB, "view", "out", *figure, cwd=tmp_path, code=3)
    (line,) = done.stderr.splitlines()
    assert "matplotlib" in line
    assert "pip install 'cdpr[plot]'" in line


@pytest.mark.slow
def test_the_examples_of_the_wheel_are_those_of_the_tree(python, tmp_path):
    rows = json.loads(run(python, "-m", "cdpr", "examples", "--json", cwd=tmp_path).stdout)
    assert all(row["file"].startswith(str(python[1])) for row in rows)
    assert {os.path.relpath(row["file"], python[1] / "cdpr" / "examples") for row in rows} == {
        str(path.relative_to(ROOT / "scenarios")) for path in (ROOT / "scenarios").rglob("*.yaml")
    }


@pytest.mark.slow
def test_the_wheel_holds_all_sources_of_fmus(python):
    """Without which no FMU can be exported."""
    of_tree = sources(ROOT)
    assert len(of_tree) > 20
    assert sources(python[1]) == of_tree


def sources(root):
    suffixes = (".c", ".cpp", ".h", ".hpp")
    return {path.relative_to(root) for path in (root / "cdpr" / "fmu").rglob("*") if path.suffix in suffixes}


@pytest.mark.slow
def test_the_wheel_has_all_headers_in_one_folder(python, tmp_path):
    done = run(python, "-c", "import cdpr; print(cdpr.get_include())", cwd=tmp_path)
    include = Path(done.stdout.strip())
    assert include == python[1] / "cdpr" / "native" / "include"
    shared = ROOT / "cdpr" / "native" / "include"
    expected = {path.relative_to(shared) for path in shared.rglob("*.h*")}
    for package in ("cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers"):
        parts = (path for path in (ROOT / package).rglob("*.hpp") if not path.is_relative_to(shared))
        expected |= {path.relative_to(ROOT) for path in parts}
    assert {path.relative_to(include) for path in include.rglob("*.h*")} == expected


@pytest.mark.slow
def test_the_wheel_has_the_kernel_library(python, tmp_path):
    code = "from cdpr.native import library; print(library.__file__, library.tables()[0][0])"
    assert str(python[1]) in run(python, "-c", code, cwd=tmp_path).stdout


# Nothing that compiles may be imported.
WITHOUT_COMPILERS = "import sys; sys.modules |= {'numba': None, 'llvmlite': None}; from cdpr.ui.cli import main; main()"


@pytest.mark.slow
@pytest.mark.parametrize(("scenario", "solver"), [("caroca", "qp"), ("caroca", "centroid"), ("cogiro_pulleys", "qp")])
def test_a_first_run_compiles_nothing_and_writes_only_its_folder(python, tmp_path, scenario, solver):
    home = tmp_path / "home"
    home.mkdir()
    chosen = ["run", scenario, "--solver", solver, *SHORT, "--out", "out"]
    run(python, "-c", WITHOUT_COMPILERS, *chosen, cwd=tmp_path, HOME=str(home), XDG_CACHE_HOME=str(home / "cache"))
    assert list(home.rglob("*")) == []
    assert sorted(path.name for path in tmp_path.iterdir()) == ["home", "out"]
