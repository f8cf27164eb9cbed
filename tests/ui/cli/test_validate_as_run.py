"""`cdpr validate` rejects what a run rejects before its first step, and nothing else."""

from __future__ import annotations

import os
from contextlib import redirect_stdout
from io import StringIO

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT

from cdpr import load_scenario
from cdpr.base.errors import CdprError, ExitCode, PluginError
from cdpr.simulation.build import build, faults
from cdpr.simulation.loop import Loop
from cdpr.ui.cli import validate

CASES = int(os.environ.get("CDPR_TEST_CASES", "12"))  # perturbed scenarios
SCENARIOS = ROOT / "scenarios"

TURN = {"type": "quintic", "duration": 3.0, "to": {"position": [0.3, 0, 1.4], "orientation": {"rpy": [0, 0, 0.3]}}}
FAST = {"type": "quintic", "duration": 3.0, "to": {"position": [0.6, 0, 1.6]}}
TARGET = {"type": "target", "position": [0, 0, 1.3]}
QUICK, SLOW = {"velocity": 5.0, "acceleration": 20.0, "jerk": 300.0}, {"velocity": 0.1, "acceleration": 2, "jerk": 30}
START = {"initial": {"position": [0, 0, 1.2]}, "simulation.duration": 4.0}

REJECTED = [
    ("caroca", START | {"trajectory": TURN, "events": [TARGET | {"time": 1.0, "limits": QUICK}]}, "angular_limits are"),
    ("caroca", START | {"trajectory": FAST, "events": [TARGET | {"time": 1.5, "limits": SLOW}]}, "no quintic"),
    ("caroca", {"controller": {"type": "cable_length", "kp": [1, 2]}}, "kp has 2 values, the robot 8 cables"),
    ("winch", {"simulation.physics_step": 0.02, "simulation.control_step": 0.02}, "physics_step 0.02 s is too long"),
]


@pytest.mark.parametrize(("name", "changes", "text"), REJECTED, ids=[text for *_, text in REJECTED])
def test_commands_rejected_by_a_run(name, changes, text):
    scenario = load_scenario(SCENARIOS / f"{name}.yaml", overrides=changes)
    with pytest.raises(CdprError, match=text) as stop:
        build(scenario)
    (fault,) = faults(scenario)
    assert str(fault.error) == str(stop.value)


def test_the_command_reports_all_with_their_places(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_text(load_scenario(SCENARIOS / "winch.yaml").yaml_in(str(tmp_path)))
    wrong = (
        "controller={type: cable_length, kp: [1, 2]}",
        "simulation.control_step=0.02",
        "simulation.physics_step=0.02",
    )
    done = CliRunner().invoke(validate.command, [str(path), *(word for one in wrong for word in ("--set", one))])
    assert done.exit_code == ExitCode.BAD_INPUT
    assert "simulation.physics_step 0.02 s is too long" in done.output
    assert "cable_length: kp has 2 values, the robot 8 cables" in done.output
    assert CliRunner().invoke(validate.command, [str(path)]).exit_code == ExitCode.OK


def test_nothing_is_started():
    """A program that a remote controller names runs in a run only."""
    scenario = load_scenario(
        SCENARIOS / "caroca.yaml", overrides={"controller": {"type": "remote", "program": "no.py"}}
    )
    assert list(faults(scenario)) == []


def perturbed(rng):
    """Return the name of an example and random changes of it, about half of which no run takes."""
    name = str(
        rng.choice(["caroca", "winch", "cogiro_pulleys", "planar", "spherical", "believed", "cable_break", "pid"])
    )
    if not (SCENARIOS / f"{name}.yaml").exists():
        name = "caroca"
    choices = [
        ("simulation.control_step", lambda: float(rng.choice([0.001, 0.002, 0.005, 0.01, 0.02]))),
        ("simulation.physics_step", lambda: float(rng.choice([0.0005, 0.001, 0.002, 0.005, 0.01]))),
        ("controller", lambda: {"type": "cable_length", "kp": rng.uniform(1, 9, rng.integers(1, 10)).tolist()}),
        ("controller", lambda: {"type": str(rng.choice(["static", "pid", "computed_torque"]))}),
        ("solver", lambda: {"type": str(rng.choice(["qp", "kernel", "centroid", "lp", "polygon", "dykstra"]))}),
        ("robot.cable.model", lambda: str(rng.choice(["ideal", "rigid", "elastic"]))),
        ("robot.cable.axial_stiffness", lambda: float(10 ** rng.uniform(2, 8))),
        ("robot.cable.damping", lambda: float(10 ** rng.uniform(-1, 6))),
        (
            "robot.winch",
            lambda: {"drum_radius": float(rng.uniform(0.02, 0.1)), "inertia": float(10 ** rng.uniform(-5, 0))},
        ),
        ("robot.platform.mass", lambda: float(10 ** rng.uniform(-2, 3))),
        ("trajectory", lambda: FAST if rng.random() < 0.5 else TURN),
        (
            "events",
            lambda: [
                TARGET
                | {"time": float(rng.uniform(0, 3)), "position": [0.0, 0.0, float(rng.uniform(0.8, 1.6))]}
                | {"limits": SLOW if rng.random() < 0.5 else QUICK}
                for _ in range(rng.integers(1, 3))
            ],
        ),
    ]
    picked = rng.choice(len(choices), rng.integers(1, 5), replace=False)
    return name, {choices[i][0]: choices[i][1]() for i in picked}


def test_verdicts_on_perturbed_scenarios_are_those_of_runs():
    rng = np.random.default_rng(int(os.environ.get("CDPR_TEST_SEED", "7")))
    verdicts = {True: 0, False: 0}
    loaded = 0
    while loaded < CASES:
        name, changes = perturbed(rng)
        try:
            scenario = load_scenario(SCENARIOS / f"{name}.yaml", backend="reference", overrides=changes)
        except CdprError:
            continue  # both load by the same function
        loaded += 1
        found = [fault.error for fault in faults(scenario)]
        try:
            with redirect_stdout(StringIO()):
                parts = build(scenario)
            parts.controller.close()
            loop = Loop(parts)
            loop.warm_up(scenario.initial.state())
            loop.close()
            parts.backend.close()
            stop = None
        except CdprError as error:
            stop = error
        assert (stop is None) == (not found), (name, changes, stop, found)
        if stop is not None:
            assert str(stop) == str(found[0])
            assert isinstance(stop, PluginError) == isinstance(found[0], PluginError)
        verdicts[stop is None] += 1
    assert min(verdicts.values()) > 0
