"""Engines against a plain semi-implicit Euler oracle, against the reference, and against themselves."""

from __future__ import annotations

import dataclasses
import hashlib
import subprocess
import sys

import numpy as np
import pytest
from conftest import GRAVITY, ROOT, random_state
from oracle import SemiImplicitEuler

import cdpr
from cdpr.model import rotations
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop
from cdpr_backends import MujocoOptions
from cdpr_backends.mujoco import make

SAME_SCHEME = 1e-9  # m and rad over 4 s closed loop; measured 2e-16
SAME_FORCE = 1e-12  # tendons against our kernel, m and rad

CAROCA = ROOT / "scenarios" / "caroca.yaml"

# A start off the trajectory, turned, with the mass off the origin and all products of inertia.
SKEWED = {
    "initial.position": [0.02, -0.01, 1.215],
    "initial.orientation": {"rpy": [0.02, -0.03, 0.01]},
    "trajectory.from": {"position": [0.0, 0.0, 1.2], "orientation": {"rpy": [0, 0, 0]}},
    "robot.platform.center_of_mass": [0.05, -0.03, 0.1],
    "robot.platform.inertia": [9.0, 19.0, 21.0, 2.0, -1.5, 3.0],
}


def closed_loop(overrides, **choice):
    return cdpr.simulate(CAROCA, overrides=overrides, **choice)


def with_oracle(overrides):
    """The same closed loop around the oracle."""
    scenario = cdpr.load_scenario(CAROCA, overrides=overrides)
    parts = build(scenario)
    oracle = SemiImplicitEuler(parts.robot, scenario.gravity, scenario.simulation.physics_step)
    oracle.reset(scenario.initial.state())
    loop = Loop(dataclasses.replace(parts, backend=oracle))
    rows = np.empty((scenario.simulation.steps + 1, len(loop.row)))
    loop.run(rows, lambda _: None)
    return cdpr.Run(cdpr.simulate(scenario, overrides={"simulation.duration": 0.001}).header, rows)


def differences(a, b):
    """Largest distance in position (m) and attitude (rad)."""
    both = dataclasses.replace(a, rows=a.rows.copy())
    both["desired_position"][:] = b.position
    both["desired_orientation"][:] = b.orientation
    return (
        float(np.linalg.norm(both.position_error, axis=1).max()),
        float(np.linalg.norm(both.orientation_error, axis=1).max()),
    )


@pytest.mark.parametrize("overrides", [{}, SKEWED])
def test_mujoco_is_semi_implicit_euler(overrides):
    assert max(differences(closed_loop(overrides, backend="mujoco"), with_oracle(overrides))) < SAME_SCHEME


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


@pytest.mark.parametrize("overrides", [{}, SKEWED])
def test_engine_error_is_first_order(overrides):
    """At a fixed control period the distance to the reference falls 8 to 12 times per decade of the physics step."""
    overrides = {**overrides, "simulation.duration": 2.0}
    errors = []
    for step in (1e-3, 1e-4):
        finer = {**overrides, "simulation.physics_step": step}
        errors.append(differences(closed_loop(finer), closed_loop(finer, backend="mujoco")))
    ratios = np.array(errors[0]) / np.array(errors[1])
    assert np.all((ratios > 8) & (ratios < 12)), ratios


@pytest.mark.parametrize("options", [MujocoOptions(), MujocoOptions(cables="native")])
def test_external_wrench_and_reset(offset_robot, options):
    """The oracle's answer with an external wrench; none is left over after it ends, nor after a reset."""
    rng = np.random.default_rng(2)
    start, command, push = random_state(rng), rng.uniform(20, 120, 8), rng.normal(size=6) * 50
    plants = [kind(offset_robot, GRAVITY, 1e-3, options) for kind in (make, SemiImplicitEuler)]
    for plant in plants:
        plant.reset(random_state(rng))
        plant.external[:] = 1e3
        plant.step(5)
        plant.reset(start)
        plant.command[:] = command
        plant.external[:] = push
        plant.step(100)
        plant.external[:] = 0.0
        plant.step(100)
    np.testing.assert_allclose(plants[0].state, plants[1].state, atol=1e-11)


def test_a_diverging_engine_is_silent(offset_robot, tmp_path, monkeypatch, capfd):
    """No word on the terminal, no file in the user's folder; the state shows it."""
    monkeypatch.chdir(tmp_path)
    backend = make(offset_robot, GRAVITY, 1e-3, MujocoOptions())
    backend.reset(random_state(np.random.default_rng(0)))
    backend.external[0] = np.nan
    backend.step(3)
    assert not np.isfinite(backend.state).all()
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


def test_moments_rounded_past_the_triangle_inequality():
    """A thin plate given with six digits; MuJoCo's compiler would refuse it."""
    overrides = {"robot.platform.inertia": [3.33333, 3.33333, 6.66667, 0, 0, 0], "simulation.duration": 0.5}
    skewed = {**SKEWED, **overrides}
    assert max(differences(closed_loop(skewed, backend="mujoco"), with_oracle(skewed))) < SAME_SCHEME


def test_state_survives_the_engine_in_any_attitude(offset_robot):
    rng = np.random.default_rng(4)
    backend = make(offset_robot, GRAVITY, 1e-3, MujocoOptions())
    for _ in range(100):
        state = random_state(rng)
        state[3:7] = rotations.from_rpy(*rng.uniform(-3, 3, 3))
        backend.reset(state)
        np.testing.assert_allclose(backend.state, state, atol=1e-12)


HASH = """
import hashlib, sys, cdpr
run = cdpr.simulate(sys.argv[1], backend=sys.argv[2], overrides={"simulation.duration": 1.0}, out=sys.argv[3])
print(hashlib.sha256(run.rows.tobytes()).hexdigest())
print(hashlib.sha256(open(sys.argv[3] + "/log.mcap", "rb").read()).hexdigest())
"""


@pytest.mark.parametrize("backend", ["reference", "mujoco"])
def test_bit_identical_in_two_processes(backend, tmp_path):
    outputs = [
        subprocess.run(
            [sys.executable, "-c", HASH, CAROCA, backend, tmp_path / seed],
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
