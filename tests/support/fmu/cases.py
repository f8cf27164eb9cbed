"""Plants that the tests of exported FMUs share."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

from cdpr.cables import chain_of
from cdpr.fmu.export import Plant, fmu_bytes
from cdpr.scenario import Scenario, load_scenario

if shutil.which(os.environ.get("CXX") or "c++") is None and not os.environ.get("CI"):
    pytest.skip("no C++ compiler", allow_module_level=True)


def quick_compiler(folder: Path, first: str = "") -> str:
    """Return the path of a compiler that does not optimise, to save time; it first runs the shell command `first`."""
    compiler = folder / "compiler"
    compiler.write_text(f'#!/bin/sh\n{first}\nexec {os.environ.get("CXX") or "c++"} "$@" -O0\n')
    compiler.chmod(0o755)
    return str(compiler)


FMI = pytest.mark.parametrize("fmi", [2, 3])
WINCH = [
    "robot.winch.drum_radius=0.05",
    "robot.winch.inertia=0.002",
    "robot.winch.viscous_friction=0.01",
    "robot.winch.coulomb_friction=0.1",
    "robot.cable.axial_stiffness=1e5",
    "robot.cable.damping=100",
]
ELASTIC = [*WINCH, "robot.cable.model=elastic"]
CURVE = "[[0.001, 60], [0.004, 500], [0.01, 2500]]"  # tensions in N
ROPE = [
    "robot.cable.creep=[[0.2, 0.02], [0.1, 1.0]]",
    "robot.cable.hysteresis_stiffness=2e4",  # N
    "robot.cable.hysteresis_tension=20",  # N
]
RIGID = [*WINCH, "robot.cable.model=rigid"]
MIXED = [*ELASTIC, "robot.cables[0].model=rigid", "robot.cables[3].model=ideal"]
SKEWED = [
    "robot.platform.center_of_mass=[0.03, -0.02, 0.06]",
    "robot.platform.inertia=[0.24, 0.25, 0.4, 0.02, -0.01, 0.03]",
]
# Scenario and changes: a diagonal and a full inertia, centre of mass off the origin, guides with and without hinge, a
# ball.
CASES = {
    "caroca": ("caroca", []),
    "cogiro": ("cogiro", []),
    "planar": ("planar", []),
    "planar_skewed": ("planar", ["robot.platform.center_of_mass=[0.08, 0.0, -0.05]"]),
    "point_mass": ("point_mass", []),
    "carriage": ("carriage", []),
    "spherical": ("spherical", SKEWED),
    "cogiro_elastic": ("cogiro", ELASTIC),
    "cogiro_rigid": ("cogiro", RIGID),
    "pulleys": ("cogiro_pulleys", []),
    "pulleys_elastic": ("cogiro_pulleys", ELASTIC),
    "pulleys_rigid": ("cogiro_pulleys", RIGID),
    "planar_elastic": ("planar", ELASTIC),
    "planar_rigid": ("planar", RIGID),
    "spherical_elastic": ("spherical", [*SKEWED, *ELASTIC]),
    "spherical_rigid": ("spherical", [*SKEWED, *RIGID]),
    "mixed": ("cogiro", MIXED),
    "pulleys_mixed": ("cogiro_pulleys", MIXED),
    "planar_mixed": ("planar", MIXED),
    "cogiro_tabulated": ("cogiro", [*WINCH, "robot.cable.model=tabulated", f"robot.cable.stiffness_table={CURVE}"]),
    "cogiro_viscoelastic": ("cogiro", [*WINCH, "robot.cable.model=viscoelastic", *ROPE]),
    "legs_elastic": ("caroca", [*ELASTIC, "robot.unilateral=false"]),
}


def scenario(case: str) -> Scenario:
    name, changes = CASES[case]
    return load_scenario(ROOT / "scenarios" / f"{name}.yaml", overrides=changes)


def plant_of(loaded: Scenario, step: float = 1e-3) -> Plant:
    """With the winches, where the robot has any."""
    winches = loaded.robot.cable_model != "ideal"
    return Plant(loaded.robot, loaded.gravity, step, loaded.initial.state(), winches)


def write(plant: Plant, fmi: int, folder: Path) -> Path:
    """Write the FMU without making it a trusted one."""
    path = folder / f"plant{fmi}.fmu"
    path.write_bytes(fmu_bytes(plant, fmi))
    return path


def load(plant: Plant, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Commands (m,), at times such that cables on winches hang slack, and an external wrench (6,) at time t."""
    m = plant.robot.m
    command = 200.0 + (400.0 if plant.winches else 200.0) * np.sin(3.0 * t + np.arange(m))
    for i, cable in enumerate(plant.robot.cables):
        if chain_of(plant.robot, cable).immediate:  # it would push with what is below 0
            command[i] = max(command[i], 0.0)
    return command, 10.0 * np.cos(2.0 * t + np.arange(6))
