"""Closed loops on every engine: against a plain semi-implicit Euler oracle, the reference, and themselves."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import subprocess
import sys
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from conftest import ROOT
from oracle import oracle
from plants import installed, plant
from spread import spread

import cdpr
from cdpr.model import rotations
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop
from cdpr.testing import samples

SAME_SCHEME = 1e-9  # m and rad over 1 to 4 s closed loop; measured 1e-14
# s of the oracle, which costs more than all the engines; another scheme is a thousand times the bound off by then.
ORACLE_RUNS = 0.25
IN_EVERY_ATTITUDE = 1e-11  # m, rad, m/s, rad/s per rad/s over 100 steps; measured 1e-13
LONG_TURN = 1e-10  # rad after 50 000 steps, each of which rounds by 2e-16; measured 1e-12
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
TOP_HEAVY = {
    "robot.platform.center_of_mass": [0.03, 0.02, 0.06],
    "robot.platform.inertia": [0.24, 0.25, 0.4, 0.02, -0.01, 0.03],
}
CASES = {
    "caroca": ("caroca", {}),
    "skewed": ("caroca", SKEWED),
    "plate": ("caroca", PLATE),
    "cogiro": ("cogiro", {}),
    "pulleys": ("cogiro_pulleys", {}),
    "planar": ("planar", {}),
    "loaded": ("planar", LOADED),
    "point_mass": ("point_mass", {}),
    "carriage": ("carriage", {}),
    "spherical": ("spherical", TOP_HEAVY),
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
        ROOT / "scenarios" / f"{name}.yaml", overrides={**overrides, "simulation.duration": ORACLE_RUNS}
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


@pytest.mark.parametrize("case", CASES)  # the oracle, the slowest part, runs once per case
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.usual("*-skewed", "*-planar")
def test_engines_are_semi_implicit_euler(engine, case):
    assert max(differences(case_run(case, engine, ORACLE_RUNS), with_oracle(case))) < SAME_SCHEME


@pytest.mark.parametrize("case", CASES)
@pytest.mark.usual("skewed", "planar")
def test_reference_offers_the_engines_scheme(case):
    """`cdpr compare` holds every engine of this scheme against it."""
    name, overrides = CASES[case]
    scheme = {"simulation.duration": ORACLE_RUNS, "backend_options.reference.scheme": "semi_implicit_euler"}
    twin = closed_loop({**overrides, **scheme}, name)
    assert max(differences(twin, with_oracle(case))) < SAME_SCHEME
    assert max(differences(twin, case_run(case, "reference", ORACLE_RUNS))) > 1000 * SAME_SCHEME


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("one", "other"), list(combinations(ENGINES, 2)))
@pytest.mark.usual("mujoco-*-pulleys", "mujoco-*-spherical")
def test_engines_agree(one, other, case):
    assert max(differences(case_run(case, one), case_run(case, other))) < SAME_SCHEME


def turned(v):
    """Unit quaternion of a rotation vector, rad."""
    angle = np.linalg.norm(v)
    return rotations.from_axis_angle(v / angle, angle) if angle > 0.0 else np.array([1.0, 0.0, 0.0, 0.0])


# Possible axes of an engine's rotation vector in our frame; DART's once did, at the last of these.
SPECIAL = [[0, 0, 0], [1e-3, 0, 0], [0, 0, np.pi], [2.9, 1.2, 0.1], [-0.6, -0.5, -0.4], [-0.6003, -0.5003, -0.4003]]


@pytest.mark.slow
@pytest.mark.parametrize("robot", [samples.free(), samples.spherical()], ids=["free", "spherical"])
@pytest.mark.parametrize("engine", ENGINES)
def test_engines_are_semi_implicit_euler_in_every_attitude(engine, robot):
    """200 random attitudes and special ones, at any speed: rotations of 1e-6 to 0.1 rad a step, through all zeros."""
    rng = np.random.default_rng(70)
    turns = [*(rotations.rotation_vector(samples.attitude(rng)) for _ in range(200)), *SPECIAL * 4]
    one, other = plant(engine, robot), plant("reference", robot, scheme="semi_implicit_euler")
    worst, speeds = [], np.geomspace(1e-3, 100.0, len(turns))
    for turn, speed in zip(turns, rng.permutation(speeds), strict=True):
        start = samples.state(rng) if robot.n == 6 else samples.spherical_state(rng)
        start[3:7] = turned(np.array(turn))
        start[10:] *= speed / np.linalg.norm(start[10:])
        for backend in (one, other):
            backend.reset(start)
            backend.command[:], backend.external[:] = 60.0, [20.0, 10.0, 400.0, 1.0, 2.0, 3.0]
            backend.step(100)
        worst.append(samples.distance(one.state, other.state) / max(1.0, speed))
    assert max(worst) < IN_EVERY_ATTITUDE


@pytest.mark.parametrize("dof", [samples.free().dof, samples.spherical().dof], ids=["free", "spherical"])
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.usual("mujoco-free")
def test_a_slow_turn_does_not_add_up(engine, dof):
    """Steps of 2e-4 rad, in each of which an exponential cut after its square would lose 1.3e-12 rad."""
    robot = dataclasses.replace(samples.ball(), dof=dof)
    start = np.concatenate([[0.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0], np.zeros(3), [0.1, -0.1, 0.14]])
    backend = plant(engine, robot, gravity=samples.NO_GRAVITY)
    backend.reset(start)
    backend.step(50_000)
    end = rotations.multiply(turned(50.0 * start[10:]), start[3:7])
    assert np.linalg.norm(rotations.between(backend.state[None, 3:7], end[None])) < LONG_TURN


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


def test_tendons_with_runge_kutta_are_of_order_four_under_a_wrench():
    """The external wrench acts at the platform's origin, not at the centre of mass, at every stage."""
    robot = cdpr.load_robot("caroca")
    platform = dataclasses.replace(robot.platform, center_of_mass=np.array([0.1, -0.07, 0.05]))
    robot = dataclasses.replace(robot, platform=platform)
    start = np.concatenate([robot.home, [0.3, -0.2, 0.1, 1.5, -2.0, 1.0]])

    def end(engine, step, **options):
        backend = plant(engine, robot, step=step, **options)
        backend.command[:] = np.linspace(300.0, 600.0, robot.m)
        backend.external[:] = [500.0, -800.0, 300.0, 60.0, -50.0, 90.0]
        backend.reset(start)
        backend.step(round(0.5 / step))
        return backend.state.copy()

    exact = end("reference", 2.5e-4)
    errors = [
        np.abs(end("mujoco", step, cables="native", integrator="rk4") - exact).max() for step in (2e-2, 1e-2, 5e-3)
    ]
    ratios = np.divide(errors[:-1], errors[1:])
    assert np.all((ratios > 14) & (ratios < 18)), ratios  # 16, and 2 of first order


@spread("engine, case", ENGINES, ["caroca", "skewed", "planar", "point_mass", "spherical"])
@pytest.mark.usual("mujoco-*", "dart-skewed")
def test_engine_error_is_first_order(engine, case):
    """At a fixed control period the distance to the reference falls 8 to 12 times per decade of the physics step."""
    errors = []
    for step in (1e-3, 1e-4):
        errors.append(differences(case_run(case, "reference", 2.0, step), case_run(case, engine, 2.0, step)))
    ratios = np.array([a / b for a, b in zip(*errors, strict=True) if a > 0.0])
    assert np.all((ratios > 8) & (ratios < 12)), ratios


HASHES = """
import hashlib, sys, cdpr
scenario, out, *backends = sys.argv[1:]
for backend in backends:
    run = cdpr.simulate(scenario, backend=backend, overrides={"simulation.duration": 0.1}, out=f"{out}-{backend}")
    print(backend, hashlib.sha256(run.rows.tobytes()).hexdigest(), end=" ")
    print(hashlib.sha256(open(f"{out}-{backend}/log.mcap", "rb").read()).hexdigest())
"""


@pytest.fixture(scope="module")
def another_process(tmp_path_factory):
    """Of each backend, hashes of rows and log in a process that differs from this one in what must not matter."""
    names = ("PYTHONHASHSEED", "OPENBLAS_NUM_THREADS")
    other = {name: "2" if os.environ.get(name) == "1" else "1" for name in names}
    done = subprocess.run(
        [
            *(sys.executable, "-c", HASHES, ROOT / "scenarios" / "caroca.yaml"),
            *(tmp_path_factory.mktemp("another") / "run", "reference", *ENGINES),
        ],
        env={**os.environ, **other},
        capture_output=True,
        text=True,
        check=True,
    )
    return {name: hashes for name, *hashes in map(str.split, done.stdout.splitlines())}


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["reference", *ENGINES])
def test_bit_identical_in_two_processes(backend, another_process, tmp_path):
    here = closed_loop({"simulation.duration": 0.1}, backend=backend, out=tmp_path / "run")
    written = here.rows.tobytes(), (tmp_path / "run" / "log.mcap").read_bytes()
    assert [hashlib.sha256(content).hexdigest() for content in written] == another_process[backend]
