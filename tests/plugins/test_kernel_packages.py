"""Packages with kernels by ctypes, cffi, numba and an extension: built, checked with the kit, used without Python."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT
from offline import has_compiler

HERE = ROOT / "tests" / "plugins"
TUTORIAL = (ROOT / "docs" / "plugin_kernels.md").read_text()
SETUPTOOLS = "70.1"  # makes wheels by itself since
# Name, plugin and requirements beside the compiler of each package.
PACKAGES = {
    "ctypes_controller": ("controller", "spring", ("setuptools",)),
    "cffi_solver": ("solver", "cffi_mid_range", ("setuptools", "cffi")),
    "extension_solver": ("solver", "least_norm", ("setuptools",)),
    "numba_solver": ("solver", "strong_cables", ("hatchling", "numba")),
}
# The same run by compiled code and by Python, and cases side by side; prints what Python did.
USE = """
import sys
import numpy as np
import cdpr
from cdpr.simulation import pipeline

role, name, scenario = sys.argv[1:]
short = {"simulation.duration": 0.1, role + ".type": name}
run = cdpr.simulate(scenario, overrides=short)
assert run.status == "finished" and np.abs(run.position_error).max() < 0.01
assert (run.solver_status == 0).mean() > 0.9
bound, pipeline.bound = pipeline.bound, lambda call: None
python = cdpr.simulate(scenario, overrides=short)
pipeline.bound = bound
assert len(python.interpreted) > 5
np.testing.assert_array_equal(run.rows, python.rows)
gains = np.linspace(10.0, 14.0, 9)
rollouts = cdpr.rollout(scenario, vary={"controller.kd": gains}, n=9, overrides=short, every=1)
one = cdpr.simulate(scenario, overrides=short | {"controller.kd": gains[3]})
np.testing.assert_array_equal(rollouts["position"][3], one.position)
print(run.interpreted)
"""


def missing(package):
    """Return why a package cannot be built here."""
    needed = PACKAGES[package][2]
    for name in needed:
        if importlib.util.find_spec(name) is None:
            return f"{name} is not installed"
    if "setuptools" not in needed:
        return ""
    import setuptools

    old = tuple(map(int, setuptools.__version__.split(".")[:2])) < tuple(map(int, SETUPTOOLS.split(".")))
    return "" if has_compiler() and not old else f"a C++ compiler and setuptools {SETUPTOOLS} are needed"


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """The environment of processes in which those that can be built are installed."""
    folder = tmp_path_factory.mktemp("kernels")
    site = folder / "site"
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    offline = ["--no-deps", "--no-build-isolation", "--no-index", "--quiet", "--disable-pip-version-check"]
    for package in PACKAGES:
        if not missing(package):
            shutil.copytree(HERE / package, folder / package)  # builds write into the source
            words = [sys.executable, "-m", "pip", "install", *offline, "--target", site, folder / package]
            subprocess.run(words, check=True, env={**os.environ, "PYTHONPATH": path})
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(site), path])}


def printed(environment, folder, *words):
    done = subprocess.run(
        [sys.executable, *words], env=environment, cwd=folder, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("package", PACKAGES)
def test_a_package_with_a_kernel(package, environment, tmp_path):
    role, name, _ = PACKAGES[package]
    if reason := missing(package):
        pytest.skip(reason)
    listed = json.loads(printed(environment, tmp_path, "-m", "cdpr", "plugins", "--json"))
    assert listed["problems"] == []
    assert name in {row["name"] for row in listed[f"{role}s"]}
    (test,) = (HERE / package).glob("test_*.py")
    shutil.copy(test, tmp_path)
    said = printed(environment, tmp_path, "-m", "pytest", "-q", "-p", "no:cacheprovider", test.name)
    assert re.search(r"\d+ passed", said)
    (tmp_path / "use.py").write_text(USE)
    scenario = str(ROOT / "scenarios" / "caroca.yaml")
    assert printed(environment, tmp_path, "use.py", role, name, scenario).splitlines()[-1] == "()"


@pytest.mark.slow
def test_the_kernel_on_our_headers_is_exported(environment, tmp_path):
    """The FMU compiles the same header."""
    if reason := missing("extension_solver"):
        pytest.skip(reason)
    scenario = str(ROOT / "scenarios" / "caroca.yaml")
    made = ["--with-controller", "--set", "solver.type=least_norm", "-o", "it.fmu"]
    printed(environment, tmp_path, "-m", "cdpr", "fmu", "export", scenario, *made)
    printed(environment, tmp_path, "-m", "cdpr", "fmu", "check", "it.fmu")


def shown():
    """The files of the packages that the documentation shows, by the last part of their names."""
    return dict(re.findall(r"^`([\w./]+)`:\n\n```\w+\n(.*?)^```$", TUTORIAL, re.DOTALL | re.MULTILINE))


@pytest.mark.parametrize(
    "file",
    [
        "ctypes_controller/setup.py",
        "ctypes_controller/cdpr_spring/spring.c",
        "ctypes_controller/cdpr_spring/controller.py",
        "cffi_solver/build_kernel.py",
        "cffi_solver/cdpr_mid_range/solver.py",
        "extension_solver/setup.py",
        "extension_solver/cdpr_least_norm/least_norm.hpp",
        "extension_solver/cdpr_least_norm/kernel.cpp",
        "extension_solver/cdpr_least_norm/solver.py",
    ],
)
def test_the_documentation_shows_the_packages_word_for_word(file):
    assert shown()[file] == (HERE / file).read_text()
