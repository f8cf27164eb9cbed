"""Parts of cables take a folder each and a line in the table: added here to a copy of the program."""

from __future__ import annotations

import json

import numpy as np
import pytest
from added_parts import ENTRIES, HEADER, HEADERS, IMPORTS, IN_THE_HEADER, PARTS
from additions import copy_of_program
from conftest import ROOT
from fmu.driver import Driver
from native_compiler import build_library
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from cdpr.log.reader import load_run
from cdpr.scenario import load_scenario

# Results of the backend `reference` for each case: pose, twist, tensions, the work of the cables and its winches; of a
# robot that is wrong, the error. Robot files are read without the compiler.
MOVES = """\
import json
import sys

from cdpr.base.errors import ScenarioError
from cdpr.scenario import load_scenario


def loaded(case):
    try:
        return load_scenario(case["file"], overrides=case["changes"])
    except ScenarioError as error:
        return str(error)


cases = json.loads(sys.argv[1])
scenarios = [loaded(case) for case in cases]
assert "numba" not in sys.modules
from cdpr.plugins.registry import registry

told = []
for case, scenario in zip(cases, scenarios, strict=True):
    if isinstance(scenario, str):
        told.append(scenario)
        continue
    entry, step = registry().get("backend", "reference"), case["step"]
    backend = entry.make(scenario.robot, scenario.gravity, step, scenario.backend_options("reference"))
    backend.reset(scenario.initial.state())
    backend.command[:], backend.external[:] = case["command"], case["external"]
    backend.step(round(case["time"] / step))
    tension = 0.0 * backend.command
    backend.read_tension(tension)
    told.append([*backend.state, *tension, backend.cable_work(), *backend.winches.state])
print(json.dumps(told))
"""

WINCH = ROOT / "scenarios" / "winch.yaml"


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """The program with these parts: a folder each, with the part and its header, and lines in the two tables."""
    folder, add, run = copy_of_program(tmp_path_factory.mktemp("tree"))
    for name, text in PARTS.items():
        (folder / "cdpr" / "cables" / name).mkdir()
        (folder / "cdpr" / "cables" / name / "__init__.py").write_text(text)
        (folder / "cdpr" / "cables" / name / f"{name}.hpp").write_text(HEADER.format(code=HEADERS[name]))
    add(None, "", "cdpr/cables/__init__.py", **IMPORTS, **ENTRIES)
    add(None, "", "cdpr/cables/parts.hpp", **IN_THE_HEADER)
    build_library(folder)
    return folder, run


def moved(tree, cases):
    """Cases of `MOVES`: a file, its changes, and the resulting motion."""
    still = {"file": str(WINCH), "command": [300.0] * 8, "external": [0.0] * 6, "step": 1e-3, "time": 1e-3}
    done = tree[1]("-c", MOVES, json.dumps([still | case for case in cases]))
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def schemes(scheme):
    return {"backend_options.reference.scheme": scheme}


EULER = schemes("semi_implicit_euler")
SPRUNG = {"robot.cable.model": "sprung", "robot.cable.spring_rate": 1e5}
GEARS = {"robot.cable.model": "geared", "robot.cable.spring_rate": 1e5, "robot.winch.gear": 1.1}
OTHER = {"robot.cables[2].winch": {"drum_radius": 0.08, "inertia": 0.01, "gear": 0.8}}
RUNG = {"robot.cables[0].exit": {"type": "ring", "rail": [1.0, 0.0, 0.0]}}

SHORT, LONG = 2e-3, 0.03  # s, that these move

# The robot on heavy cables, well off its rest.
DENSITY = 1.5 + 0.2 * np.arange(8)  # kg/m
HEAVY_OWN = {
    "robot.cable.damping": 0.0,
    "robot.winch.coulomb_friction": 0.0,
    **{f"robot.cables[{i}].linear_density": density for i, density in enumerate(DENSITY.tolist())},
}
HEAVY_START = {"initial.velocity": [0.1, -0.2, 0.3], "initial.angular_velocity": [0.3, 0.2, -0.4]}
HEAVY_PULL = {"command": (300.0 + 20.0 * np.arange(8)).tolist(), "external": [50.0, -30.0, 20.0, 15.0, -10.0, 25.0]}


def on_heavy_cables(scheme, step, time):
    changes = {"robot.cable.model": "heavy", **HEAVY_OWN, **HEAVY_START, **schemes(scheme)}
    return {"changes": changes, "step": step, "time": time, **HEAVY_PULL}


def lengths(state):
    """Of the robot's cables from anchor to anchor, (8,), m."""
    anchors = load_scenario(WINCH).robot.anchors
    arms = anchors[:, 3:] @ Rotation.from_quat(state[3:7], scalar_first=True).as_matrix().T
    return np.linalg.norm(anchors[:, :3] - state[:3] - arms, axis=1)


def heavy_oracle(robot, state, gravity, command, external, time):
    """The same by scipy, from the equations: elastic chords, half of a cable's weight at each end, drums, Euler."""
    A, B, m = robot.anchors[:, :3], robot.anchors[:, 3:], robot.m
    winch, EA = robot.cables[0].winch, robot.cables[0].axial_stiffness
    density = np.array([cable.linear_density for cable in robot.cables])
    inertia, mass, r = robot.platform.inertia, robot.platform.mass, winch.drum_radius

    def cables(y):
        R = Rotation.from_quat(y[3:7], scalar_first=True).as_matrix()
        arms = B @ R.T
        line = A - y[:3] - arms
        length, unwound = np.linalg.norm(line, axis=1), y[13 : 13 + m]
        chord = (np.maximum(EA * (length / unwound - 1.0), 0.0) / length)[:, None] * line
        half = 0.5 * (density * unwound)[:, None] * gravity
        return R, arms, line, length, chord + half, np.linalg.norm(chord - half, axis=1)

    def slope(t, y):
        R, arms, _, _, force, tension = cables(y)
        w, speed = y[10:13], y[13 + m : 13 + 2 * m]
        moment = np.cross(arms, force).sum(axis=0) + external[3:]
        about = R @ inertia @ R.T
        friction = winch.viscous_friction * speed + winch.coulomb_friction * np.tanh(speed / winch.coulomb_speed)
        turning = 0.5 * np.array([-w @ y[4:7], *(y[3] * w + np.cross(w, y[4:7]))])
        acceleration = (force.sum(axis=0) + external[:3]) / mass + gravity
        spin = np.linalg.solve(about, moment - np.cross(w, about @ w))
        power = np.sum(force * (y[7:10] + np.cross(w, arms)))
        drums = (r * (command - tension) - friction) / winch.inertia
        return np.concatenate([y[7:10], turning, acceleration, spin, -r * speed, drums, [power]])

    y = np.concatenate([state, np.ones(m), np.zeros(m + 1)])
    _, arms, line, length, _, _ = cables(y)
    y[13 : 13 + m] = length / (1.0 + command / EA)
    y[13 + m : 13 + 2 * m] = np.sum(line / length[:, None] * (state[7:10] + np.cross(state[10:], arms)), axis=1) / r
    y = solve_ivp(slope, (0.0, time), y, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return np.concatenate([y[:13], cables(y)[-1], y[-1:]])


def heavy_truth(time):
    scenario = load_scenario(WINCH, overrides={**HEAVY_OWN, **HEAVY_START})
    given = map(np.array, HEAVY_PULL.values())
    return heavy_oracle(scenario.robot, scenario.initial.state(), scenario.gravity, *given, time)


@pytest.mark.slow
def test_parts_with_keys_of_their_own(tree):
    """A number declared in its part: files contain it, wrong values are reported, kernels and plant use it."""
    lacking, wrong, unit, unasked, whole, known, bent = moved(
        tree,
        [
            {"changes": {"robot.cable.model": "geared"}},
            {"changes": {**SPRUNG, "robot.cables[3].spring_rate": -2}},
            {"changes": {**SPRUNG, "robot.cable.spring_rate": "3 kN/m"}},
            {"changes": {**SPRUNG, **EULER}},  # a drum without gear needs no ratio
            {"changes": {**GEARS, **OTHER, **RUNG, **EULER}},
            {"changes": {"believed.cable.spring_rat": 2e5}},
            on_heavy_cables("rk4", 1e-3, SHORT),
        ],
    )
    assert "cable.model geared needs the spring rate (N/m) of each cable: give cable.spring_rate for all, or" in lacking
    assert "cable.model geared needs the gear ratio of each cable: give winch.gear for all, or winch.gear" in lacking
    assert "robot.cables[3].spring_rate: must be greater than 0 (N/m), got -2" in wrong
    assert "robot.cable.spring_rate: expected a number (N/m), got '3 kN/m'; write 3000, without the unit" in unit
    assert "did you mean 'spring_rate'?" in known
    plain, geared = np.array(unasked), np.array(whole)
    tension, unwound, speed = slice(13, 21), slice(22, 38, 2), slice(23, 38, 2)
    np.testing.assert_allclose(plain[speed], 0.0, atol=1e-9)  # the tension is the command yet
    radius, inertia, ratio = np.full(8, 0.05), np.full(8, 0.002), np.full(8, 1.1)
    radius[2], inertia[2], ratio[2] = 0.08, 0.01, 0.8
    np.testing.assert_allclose(geared[speed], 1e-3 * radius * (ratio - 1.0) * 300.0 / inertia, rtol=1e-6)
    for row in (plain, geared):
        length = lengths(row)[1:]  # the first may leave at its ring
        np.testing.assert_allclose(row[tension][1:], 1e5 * (length - row[unwound][1:]), rtol=1e-9)

    truth = heavy_truth(SHORT)
    np.testing.assert_allclose(bent[:21], truth[:21], rtol=1e-6, atol=1e-6)


@pytest.mark.slow
def test_parts_of_cables(tree):
    """Use of the parts by the command line and by an FMU."""
    folder, run = tree
    ring, sprung = ("--set", "robot.cables[0].exit={type: ring, rail: [1.0, 0.0, 0.0]}"), "robot.cable.model=sprung"
    spring = ("--set", sprung, "--set", "robot.cable.spring_rate=1e5")
    unknown = run("validate", WINCH, "--set", "robot.cable.model=spring")
    names = "ideal, rigid, elastic, catenary, tabulated, viscoelastic, sprung, geared, heavy, inextensible"
    assert f"expected one of {names}, got 'spring'" in unknown.stderr
    lacking = run("validate", ROOT / "scenarios" / "caroca.yaml", "--set", sprung)
    assert "cable.model sprung needs the spring rate (N/m) of each cable" in lacking.stderr
    short = ("--set", "simulation.duration=0.02", "--no-report", "--out", folder / "parts")
    done = run("run", WINCH, *ring, *spring, *short)
    assert done.returncode == 0, done.stderr
    told = load_run(folder / "parts")
    tips = told.position + np.array([0.6, -0.3, -0.2])  # it hardly turns in so short a time
    np.testing.assert_allclose(told.length[:, 0], np.hypot(tips[:, 1] + 2.0, tips[:, 2] - 3.5), atol=1e-6)
    assert told.header.cable_model == "sprung"
    assert (told.cable_tension > 50.0).all()

    # Their headers are in the FMU.
    fmu = ("fmu", "export", WINCH, "-o", folder / "parts.fmu", "--force", "--with-winch", "--json")
    done = run(*fmu, *ring, *spring)
    assert done.returncode == 0, done.stderr
    with Driver(folder / "parts.fmu") as driver:
        driver.set("command", np.full(8, 300.0))
        stretch = driver.get("cable_length") - driver.get("unstretched_length")
        np.testing.assert_allclose(driver.get("cable_tension"), 1e5 * stretch, rtol=1e-9)
        np.testing.assert_allclose(driver.get("cable_tension"), 300.0, rtol=1e-9)


@pytest.mark.slow
def test_a_span_that_bends(tree):
    """Its force on the platform is not along its chord, and the robot moves as it must."""
    folder, run = tree
    steps = (1e-3, 5e-4)
    cases = [on_heavy_cables(scheme, step, LONG) for scheme in ("rk4", "semi_implicit_euler") for step in steps]
    truth = heavy_truth(LONG)
    coarse, fine, euler, finer_euler = (np.abs(np.array(row[:22]) - truth) for row in moved(tree, cases))
    for part in (slice(7), slice(7, 13), slice(13, 21), slice(21, 22)):  # pose, twist, tensions, work
        assert 12.0 < coarse[part].max() / fine[part].max() < 30.0  # order four
        assert 1.8 < euler[part].max() / finer_euler[part].max() < 2.4  # order one
    assert fine[:13].max() < 1e-8
    assert fine[13:].max() < 1e-3 < 1.0 < np.ptp(truth[13:21])

    heavy = [f"--set={key}={value}" for key, value in HEAVY_OWN.items()] + ["--set=robot.cable.model=heavy"]
    short = ("--set", "simulation.duration=0.02", "--no-report", "--json", "--out", folder / "heavy")
    done = run("run", WINCH, *heavy, *short)
    assert done.returncode == 0, done.stderr
    refused = run("fmu", "export", WINCH, "-o", folder / "heavy.fmu", "--only-winch", *heavy)
    assert refused.returncode == 2
    assert "has model heavy: it sags" in refused.stderr
