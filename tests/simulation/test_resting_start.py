"""Runs with `initial.equilibrium` start at the pose of rest for the first commands of the winches."""

from __future__ import annotations

import re

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT
from plants import installed
from scipy.optimize import brentq

import cdpr
from cdpr.base.errors import CdprError
from cdpr.scenario import load_scenario
from cdpr.simulation.far_start import start_problems

SCENARIOS = ROOT / "scenarios"
HELD = {"initial.equilibrium": True, "trajectory": {"type": "hold"}, "simulation.duration": 1.0}
STILL = 1e-11  # m: round-off of cables of some metres, over a thousand steps
ENGINES = installed("reference", "mujoco", "bullet", "dart")
LENGTHS = {"type": "inverse_kinematics"}
STEPPER = {"type": "stepper", "steps_per_turn": 200, "drum_radius": 0.01, "stall_torque": 2.0}


def held(scenario, backend="reference", **changes):
    return cdpr.simulate(SCENARIOS / scenario, backend=backend, overrides=HELD | changes)


def moved(run):
    return np.abs(run.position - run.position[0]).max()


@pytest.mark.parametrize("backend", ENGINES)
@pytest.mark.parametrize("scenario", ["hangprinter.yaml", "camera_robot.yaml"])
def test_the_first_second_is_at_rest(scenario, backend):
    """With pretension 0, the lines are slack at the initial pose."""
    run = held(scenario, backend, controller=LENGTHS)
    assert moved(run) < STILL
    assert "start" not in {event.kind for event in run.events}
    assert np.abs(run.position_error[0]).max() > 1e-3  # the motion starts at the initial pose


def test_without_the_key_the_platform_drops():
    run = cdpr.simulate(SCENARIOS / "camera_robot.yaml", overrides=HELD | {"initial.equilibrium": False})
    assert moved(run) > 0.1
    assert "start" in {event.kind for event in run.events}


def test_camera_robot_rests_as_in_closed_form():
    """Four lines at one height above a point: 4 EA (l / l0 - 1) sin(slope) = m g, from the data of the file."""
    scenario = load_scenario(SCENARIOS / "camera_robot.yaml")
    robot, (x, y, z) = scenario.robot, scenario.initial.position
    (height,) = set(robot.anchors[:, 2] - robot.anchors[:, 5])
    reach = np.hypot(*(robot.anchors[0, :2] - robot.anchors[0, 3:5] - (x, y)))
    unloaded = np.hypot(reach, height - z)
    stiffness = robot.cables[0].axial_stiffness

    def unbalanced(at):
        length = np.hypot(reach, height - at)
        return 4.0 * stiffness * (length / unloaded - 1.0) * (height - at) / length - 9.81 * robot.platform.mass

    low = brentq(unbalanced, z - 0.5, z, xtol=1e-14)
    assert held("camera_robot.yaml").position[0] == pytest.approx([x, y, low], abs=1e-9)  # m: the search ends there


@pytest.mark.parametrize(
    ("scenario", "changes"),
    [
        ("hangprinter.yaml", {"robot.winch": {"type": "velocity"}}),
        ("hangprinter.yaml", {"robot.winch": STEPPER}),
        ("hangprinter.yaml", {"drives": {"resolution": 0.01, "delay": 0.02}}),
        ("sagging.yaml", {"robot": "robots/cogiro_servos.yaml", "controller": LENGTHS | {"pretension": 300.0}}),
        ("caroca.yaml", {"controller": LENGTHS}),
    ],
    ids=["rates", "steppers", "drives", "heavy cables on servos", "tensions"],
)
def test_all_winches_start_at_rest(scenario, changes):
    run = held(scenario, **changes)
    assert moved(run) < STILL
    assert np.ptp(run.cable_tension, axis=0).max() < 1e-8  # N: round-off of a stiff cable's length


def test_only_one_pose_holds_with_lengths_that_are_rounded():
    """Steps of 10 mm give other lengths, and the start is the pose of rest for these."""
    plain, coarse = held("hangprinter.yaml"), held("hangprinter.yaml", drives={"resolution": 0.01})
    assert np.abs(plain.position[0] - coarse.position[0]).max() > 1e-4


def test_runs_rollouts_and_snapshots_have_the_same_bits():
    changes = {"initial.equilibrium": True, "simulation.duration": 1.0, "controller.pretension": 5.0}
    scenario = load_scenario(SCENARIOS / "hangprinter.yaml", overrides=changes)
    run = cdpr.simulate(scenario)
    many = cdpr.rollout(scenario, 3, vary={"controller.pretension": [18.0, 5.0, 2.0]})
    np.testing.assert_array_equal(many.position[1, -1], run.position[-1])
    with cdpr.Simulation(scenario) as simulation:
        start = simulation.snapshot()
        simulation.step(500)
        simulation.restore(start)
        np.testing.assert_array_equal(simulation.state[:3], run.position[0])
        simulation.step(500)
        np.testing.assert_array_equal(simulation.state[:3], run.position[-1])


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        (
            {"controller": {"type": "computed_torque"}},
            r"initial.equilibrium: the first commands of controller 'computed_torque' depend on the pose .*: choose a "
            r"controller without feedback \(inverse_kinematics\), or remove the key",
        ),
        ({"initial.velocity": [0.0, 0.0, 0.1]}, "initial.equilibrium: a platform at rest has no velocity"),
    ],
    ids=["feedback", "velocity"],
)
def test_a_start_that_is_not_defined_is_rejected(changes, text):
    with pytest.raises(CdprError, match=text):
        held("hangprinter.yaml", **changes)


def test_tensions_that_hold_nothing_are_reported():
    """The controller assumes half of the mass, and its constant tensions let the platform fall."""
    text = "initial.equilibrium: no pose of rest was found .*: the platform moves away: no cable holds it"
    with pytest.raises(CdprError, match=text):
        held("caroca.yaml", controller=LENGTHS, believed={"platform": {"mass": 50.0}})


def test_validate_names_the_key(tmp_path):
    text = (SCENARIOS / "hangprinter.yaml").read_text()
    (tmp_path / "robots").symlink_to(SCENARIOS / "robots")
    text = text.replace("[0.0, 0.0, 0.3]\n", "[0.0, 0.0, 0.3]\n  equilibrium: true\n", 1)
    (tmp_path / "s.yaml").write_text(text.replace("{type: inverse_kinematics, pretension: 18}", "{type: static}"))
    done = cdpr_here("validate", "s.yaml", code=2, cwd=tmp_path)
    line = text.splitlines().index("  equilibrium: true") + 1
    assert f"s.yaml:{line}:16: initial.equilibrium: the first commands" in done.stderr


def test_a_payload_from_the_start_belongs_to_the_rest():
    payload = {"type": "payload", "mass": 5.0, "time": 0.0}
    run = cdpr.simulate(SCENARIOS / "camera_robot.yaml", overrides={**HELD, "events": [payload]})
    assert np.abs(run.position - run.position[0]).max() < 1e-9  # m: it stays at rest to round-off


SOFT = {"robot.cable.axial_stiffness": 500.0}
FAR_STARTS = {
    "turned over": ("caroca", {"controller": LENGTHS}, ["0.053 m and 180 deg", r"0.35 m \(5% of the frame\)"]),
    "far below": ("camera_robot", SOFT, ["0.424 m and 0 deg", r"0.2 m \(5% of the frame\)", "flex_compensation"]),
}


@pytest.mark.parametrize(("name", "changes", "texts"), FAR_STARTS.values(), ids=FAR_STARTS)
def test_a_pose_of_rest_far_from_the_start_is_warned_of(name, changes, texts):
    scenario = load_scenario(SCENARIOS / f"{name}.yaml", overrides={**HELD, **changes, "simulation.duration": 0.01})
    run = cdpr.simulate(scenario)
    ((path, text),) = start_problems(scenario)
    (event,) = (event for event in run.events if event.text.startswith("initial.equilibrium"))
    assert (event.kind, path) == ("start", ("initial", "equilibrium"))
    assert event.text == f"initial.equilibrium: {text}"
    for each in texts:
        assert re.search(each, text)
    at = np.round(run.position[0], 6)
    assert f"position [{', '.join(f'{value + 0.0:.4g}' for value in at)}]" in text


def test_the_remedies_of_a_far_start():
    scenario = load_scenario(SCENARIOS / "camera_robot.yaml", overrides=HELD | SOFT)
    assert start_problems(scenario)
    assert start_problems(scenario.with_changes({"controller.flex_compensation": True})) == []


@pytest.mark.parametrize("name", ["camera_robot", "hangprinter"])
def test_stretch_and_sag_of_the_examples_are_near(name):
    scenario = load_scenario(SCENARIOS / f"{name}.yaml", overrides={**HELD, "simulation.duration": 0.01})
    assert start_problems(scenario) == []
    assert [event for event in cdpr.simulate(scenario).events if event.kind == "start"] == []


def test_validate_warns_of_a_far_start_and_rejects_one_without_rest():
    given = ("--set", "initial.equilibrium=true", "--set", "trajectory={type: hold}")
    far = cdpr_here("validate", "camera_robot", *given, "--set", "robot.cable.axial_stiffness=500")
    assert "initial.equilibrium: the pose of rest for the first commands is 0.424 m" in far.stderr
    light = ("--set", "controller={type: inverse_kinematics}", "--set", "believed={platform: {mass: 50}}")
    none = cdpr_here("validate", "caroca", *given, *light, code=2)
    assert "initial.equilibrium: no pose of rest was found" in none.stderr
