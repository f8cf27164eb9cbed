"""Start at the robot's home by default; angles in degrees; messages about the form of values."""

from __future__ import annotations

import math

import numpy as np
import pytest
import yaml
from conftest import ROOT

from cdpr.base.errors import ScenarioError
from cdpr.model import rotations
from cdpr.scenario import load_robot, load_scenario
from cdpr.ui.cli.pose_option import parse_pose

pytestmark = pytest.mark.core

CAROCA = ROOT / "scenarios" / "caroca.yaml"
DATA = yaml.safe_load(CAROCA.read_text())
TEXT = yaml.safe_dump({key: value for key, value in DATA.items() if key != "initial"})
TURNED = {"position": [0.1, 0.2, 1.3], "orientation": {"rpy": [0, 0, 0.2]}}


def load(changes=(), text=TEXT):
    return load_scenario(CAROCA, text=text, overrides=changes)


def problem(changes=(), text=TEXT):
    with pytest.raises(ScenarioError) as caught:
        load(changes, text)
    (line,) = caught.value.problems
    return line


def test_a_run_begins_at_home():
    scenario = load({"robot.home": TURNED})
    assert scenario.initial.position == (0.1, 0.2, 1.3)
    np.testing.assert_array_equal(scenario.initial.state()[:7], scenario.robot.home)
    assert not scenario.initial.state()[7:].any()
    assert scenario == load_scenario(CAROCA, text=scenario.resolved_yaml())  # contained in the file


@pytest.mark.parametrize(
    ("initial", "position", "yaw"),
    [
        ({"velocity": [0, 0, 0.1]}, [0.1, 0.2, 1.3], 0.2),
        ({"orientation": {"rpy": [0, 0, -0.1]}}, [0.1, 0.2, 1.3], -0.1),
        ({"position": [0, 0, 1]}, [0, 0, 1], 0.0),  # upright, as ever
    ],
)
def test_messages_persist(initial, position, yaw):
    state = load({"robot.home": TURNED, "initial": initial}).initial.state()
    np.testing.assert_array_equal(state[:3], position)
    np.testing.assert_allclose(state[3:7], rotations.from_rpy(0, 0, yaw), atol=1e-15)


def test_it_follows_the_robot_and_what_is_changed_later():
    scenario = load()
    assert scenario.with_changes({"robot.home.position": [0, 0, 1.5]}).initial.position == (0, 0, 1.5)
    assert scenario.with_changes({"robot": "robots/cogiro.yaml"}).initial.position == (0, 0, 2)
    part = scenario.with_changes({"initial.position[2]": 1.6})
    assert part.initial.position == (0, 0, 1.6)
    assert part.with_changes({"robot.home.position": [0, 0, 1.5]}).initial.position == (0, 0, 1.6)
    assert scenario.initial.position == (0, 0, 1.2)


def test_home_is_given_from_a_base_at_another_position():
    base = {"position": [1, 0, 0.5], "orientation": {"rpy_deg": [0, 0, 90]}}
    scenario = load({"robot.frame": base, "robot.home": TURNED, "trajectory": {"type": "hold"}})
    np.testing.assert_allclose(scenario.initial.state()[:7], scenario.robot.home, atol=1e-15)


def test_without_home_it_is_required():
    robot = yaml.safe_load((ROOT / "scenarios" / "robots" / "caroca.yaml").read_text())
    del robot["home"]
    text = yaml.safe_dump({**yaml.safe_load(TEXT), "robot": robot})
    required = "required but not given: state of the platform at time 0; default: at rest at the robot's home"
    assert f"initial: {required}" in problem((), text)
    assert "initial.position: required but not given" in problem({"initial": {"velocity": [0, 0, 0]}}, text)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"robot.home.position": [0, 1]}, "robot.home.position: expected 3 numbers"),
        ({"robot": "robots/no.yaml"}, "robot: there is no file"),
        ({"robot.frame": {"position": 1}}, "robot.frame.position: "),
        ({"initial": None}, "initial: "),
        ({"robot.home": None}, "robot.home: no value is given"),
        (
            {"robot.home.orientation": {"rpy_deg": [0, 20, 0]}, "robot.dof": ["x", "y", "z", "rz"]},
            "robot.home.orientation: may differ from upright only about the free directions",
        ),
    ],
)
def test_errors_of_home_are_reported_alone(changes, told):
    assert told in problem(changes)


def test_degrees():
    for given, meant in [
        ({"rpy_deg": [10, -20, 30]}, {"rpy": np.radians([10, -20, 30]).tolist()}),
        (
            {"euler": {"angles_deg": [10, -20, 30], "order": "ZYX"}},
            {"euler": {"angles": np.radians([10, -20, 30]).tolist(), "order": "ZYX"}},
        ),
    ]:
        scenarios = [load({"initial.orientation": form}) for form in (given, meant)]
        states = [scenario.initial.state() for scenario in scenarios]
        assert states[0].tobytes() == states[1].tobytes()
        assert scenarios[0] == load_scenario(CAROCA, text=scenarios[0].resolved_yaml())
    sine = {"type": "sine", "time": 0, "force": [1, 0, 0], "frequency": 1}
    turned = load({"events": [{**sine, "phase_deg": 90}]})
    assert turned.events[0].wrench_profile(0.001).phase == math.pi / 2
    assert turned == load_scenario(CAROCA, text=turned.resolved_yaml())


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"initial.orientation": {"rpy": [0, 0, 1], "rpy_deg": [0, 0, 1]}}, "exactly one of rpy, rpy_deg, quaternion"),
        ({"initial.orientation": {"euler": {"order": "XYZ"}}}, "exactly one of angles (rad) and angles_deg (deg)"),
        (
            {"events": [{"type": "sine", "force": [1, 0, 0], "frequency": 1, "phase": 1, "phase_deg": 90}]},
            "at most one of phase (rad) and phase_deg (deg)",
        ),
    ],
)
def test_one_unit_is_enough(changes, told):
    assert told in problem(changes)


@pytest.mark.parametrize(
    ("angles", "told"),
    [([0, 0, 400], "400 degrees is more than a whole turn: the attitude is that of 40 degrees"), ([0, 0, 360], "")],
)
def test_more_than_a_whole_turn_in_degrees(angles, told):
    found = [row.text for row in load({"initial.orientation": {"rpy_deg": angles}}).warnings]
    assert found == [told] * bool(told)


def test_pose_of_the_command_line_in_degrees():
    robot = load_robot(ROOT / "scenarios" / "robots" / "caroca.yaml")
    turned = parse_pose(f"0,0,1.5,0,{math.radians(-5)!r},{math.radians(30)!r}", robot)
    assert parse_pose("0,0,1.5,0,-5 deg,30deg", robot).tobytes() == turned.tobytes()
    for wrong in ("0,0,1deg", "0,0,1,0,0,30degs", "0,0,1,0,0,deg"):
        with pytest.raises(Exception, match="30deg"):
            parse_pose(wrong, robot)


@pytest.mark.parametrize(
    ("key", "value", "remedy"),
    [
        ("robot.platform.mass", "25 kg", "write 25, without the unit: it is always kg"),
        ("robot.platform.mass", "25kg", "write 25, without the unit: it is always kg"),
        ("robot.platform.mass", "2,5 t", "write 2500, without the unit: it is always kg"),
        ("robot.platform.mass", "25 lb", "write the number alone, in kg"),
        ("robot.platform.mass", "25 m", "write the number alone, in kg"),
        ("simulation.control_step", "1 ms", "write 0.001, without the unit: it is always s"),
        ("initial.position", [0, 0, "1200 mm"], "write 1.2, without the unit: it is always m"),
        ("robot.cable.damping", "0.1 kN s/m", "write 100, without the unit: it is always N s/m"),
        ("simulation.seed", "7 m", "write the number alone"),
        ("initial.orientation", {"rpy": [0, 0, "30 deg"]}, "write 0.523598775598, without the unit: it is always rad"),
    ],
)
def test_a_value_with_a_unit_is_reported_with_the_correct_form(key, value, remedy):
    assert problem({key: value}).endswith(f"; {remedy}")


def test_a_text_that_is_no_quantity_gets_no_remedy():
    for value in ("heavy", "25 ", "kg 25", "1.5.2 kg"):
        assert problem({"robot.platform.mass": value}).endswith(f"got {value!r}")


def test_a_name_with_blanks_is_reported_with_the_correct_form():
    assert problem({"name": "my  robot 2"}).endswith("got 'my  robot 2'; write my_robot_2")
    assert problem({"robot.cables[0].name": "front left"}).endswith("; write front_left")
    assert problem({"name": "a/b"}).endswith("got 'a/b'")


def test_common_cable_values_are_written_once():
    scenario = load(
        {"robot.cable.diameter": 0.004, "robot.cable.linear_density": 0.08, "robot.cables[2].diameter": 0.006}
    )
    assert [cable.diameter for cable in scenario.robot.cables[:3]] == [0.004, 0.004, 0.006]
    assert {cable.linear_density for cable in scenario.robot.cables} == {0.08}
    assert "robot.cable.linear_density" in scenario.unused  # by ideal cables
    assert not [key for key in scenario.unused if "diameter" in key]  # clearances are computed from it
