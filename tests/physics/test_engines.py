"""Closed loops on every engine: against a plain semi-implicit Euler oracle, the reference, and themselves."""

from __future__ import annotations

import dataclasses
import hashlib
import subprocess
import sys
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from conftest import ROOT
from oracle import oracle
from plants import installed

import cdpr
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop

SAME_SCHEME = 1e-9  # m and rad over 4 s closed loop; measured 1e-14, DART 2e-10 rad
SAME_PLACE = 1e-9  # m, between two engines
SAME_ATTITUDE = 1e-7  # rad
SAME_FORCE = 1e-12  # tendons against our kernel, m and rad

ENGINES = installed("mujoco", "bullet", "dart")

# A start off the trajectory, turned, with the mass off the origin and all products of inertia.
SKEWED = {
    "initial.position": [0.02, -0.01, 1.215],
    "initial.orientation": {"rpy": [0.02, -0.03, 0.01]},
    "trajectory.from": {"position": [0.0, 0.0, 1.2], "orientation": {"rpy": [0, 0, 0]}},
    "robot.platform.center_of_mass": [0.05, -0.03, 0.1],
    "robot.platform.inertia": [9.0, 19.0, 21.0, 2.0, -1.5, 3.0],
}
# A thin plate given with six digits, its moments past the triangle inequality by their rounding.
PLATE = {**SKEWED, "robot.platform.inertia": [3.33333, 3.33333, 6.66667, 0, 0, 0]}
LOADED = {"robot.platform.center_of_mass": [0.03, 0.02, -0.04]}
CASES = {
    "caroca": ("caroca", {}),
    "skewed": ("caroca", SKEWED),
    "plate": ("caroca", PLATE),
    "cogiro": ("cogiro", {}),
    "planar": ("planar", {}),
    "loaded": ("planar", LOADED),
    "point_mass": ("point_mass", {}),
    "carriage": ("carriage", {}),
}


@cache
def case_run(case, backend, seconds=4.0, step=1e-3):
    scenario, overrides = CASES[case]
    overrides = {**overrides, "simulation.duration": seconds, "simulation.physics_step": step}
    return closed_loop(overrides, scenario, backend=backend)


def closed_loop(overrides, scenario="caroca", **choice):
    return cdpr.simulate(ROOT / "scenarios" / f"{scenario}.yaml", overrides=overrides, **choice)


@cache
def with_oracle(case):
    """The same closed loop around the oracle."""
    name, overrides = CASES[case]
    scenario = cdpr.load_scenario(
        ROOT / "scenarios" / f"{name}.yaml", overrides={**overrides, "simulation.duration": 4.0}
    )
    parts = build(scenario)
    plant = oracle(parts.robot, scenario.gravity, scenario.simulation.physics_step)
    plant.reset(scenario.initial.state())
    loop = Loop(dataclasses.replace(parts, backend=plant))
    rows = np.empty((scenario.simulation.steps + 1, len(loop.row)))
    loop.run(rows, lambda _: None)
    return cdpr.Run(cdpr.simulate(scenario, overrides={"simulation.duration": 0.001}).header, rows)


def differences(a, b):
    """Largest distance in position (m) and attitude (rad)."""
    rows, columns = a.rows.copy(), a.header.layout.columns
    rows[:, columns["desired_position"]] = b.position
    rows[:, columns["desired_orientation"]] = b.orientation
    both = dataclasses.replace(a, rows=rows)
    return (
        float(np.linalg.norm(both.position_error, axis=1).max()),
        float(np.linalg.norm(both.orientation_error, axis=1).max()),
    )


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("engine", ENGINES)
def test_engines_are_semi_implicit_euler(engine, case):
    assert max(differences(case_run(case, engine), with_oracle(case))) < SAME_SCHEME


@pytest.mark.parametrize("case", CASES)
def test_reference_offers_the_engines_scheme(case):
    """`cdpr compare` holds every engine of this scheme against it."""
    name, overrides = CASES[case]
    scheme = {"simulation.duration": 4.0, "backend_options.reference.scheme": "semi_implicit_euler"}
    twin = closed_loop({**overrides, **scheme}, name)
    assert max(differences(twin, with_oracle(case))) < SAME_SCHEME
    assert max(differences(twin, case_run(case, "reference"))) > 1000 * SAME_SCHEME


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("one", "other"), list(combinations(ENGINES, 2)))
def test_engines_agree(one, other, case):
    place, attitude = differences(case_run(case, one), case_run(case, other))
    assert place < SAME_PLACE
    assert attitude < SAME_ATTITUDE


@pytest.mark.parametrize("overrides", [{}, SKEWED])
def test_native_tendons_pull_like_our_kernel(overrides):
    kernel = closed_loop(overrides, backend="mujoco")
    tendons = closed_loop({**overrides, "backend_options.mujoco.cables": "native"}, backend="mujoco")
    assert max(differences(kernel, tendons)) < SAME_FORCE


def test_tendons_with_runge_kutta_reach_the_reference():
    """Order four where the geometry is evaluated at every stage."""
    options = {"backend_options.mujoco": {"cables": "native", "integrator": "rk4"}}
    tendons = closed_loop({**SKEWED, **options}, backend="mujoco")
    assert max(differences(closed_loop(SKEWED), tendons)) < SAME_SCHEME


@pytest.mark.parametrize("case", ["caroca", "skewed", "planar", "point_mass"])
@pytest.mark.parametrize("engine", ENGINES)
def test_engine_error_is_first_order(engine, case):
    """At a fixed control period the distance to the reference falls 8 to 12 times per decade of the physics step."""
    errors = []
    for step in (1e-3, 1e-4):
        errors.append(differences(case_run(case, "reference", 2.0, step), case_run(case, engine, 2.0, step)))
    ratios = np.array([a / b for a, b in zip(*errors, strict=True) if a > 0.0])
    assert np.all((ratios > 8) & (ratios < 12)), ratios


HASH = """
import hashlib, sys, cdpr
run = cdpr.simulate(sys.argv[1], backend=sys.argv[2], overrides={"simulation.duration": 1.0}, out=sys.argv[3])
print(hashlib.sha256(run.rows.tobytes()).hexdigest())
print(hashlib.sha256(open(sys.argv[3] + "/log.mcap", "rb").read()).hexdigest())
"""


@pytest.mark.parametrize("backend", ["reference", *ENGINES])
def test_bit_identical_in_two_processes(backend, tmp_path):
    outputs = [
        subprocess.run(
            [sys.executable, "-c", HASH, ROOT / "scenarios" / "caroca.yaml", backend, tmp_path / seed],
            env={"PYTHONHASHSEED": seed, "OPENBLAS_NUM_THREADS": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    ]
    assert outputs[0] == outputs[1]
    here = closed_loop({"simulation.duration": 1.0}, backend=backend)
    assert hashlib.sha256(here.rows.tobytes()).hexdigest() == outputs[0].split()[0]
