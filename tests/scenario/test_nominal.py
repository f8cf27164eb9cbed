"""Nominal robot of a scenario: merge into the robot, checks, positions of problems, and both spellings of its key."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from scenario_cases import BASE, load, problem, problems
from study_cases import write_study

import cdpr
from cdpr.analysis.study import load_study
from cdpr.scenario import load_scenario

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
BELIEVED = """\
believed:
  platform: {mass: 140, center_of_mass: [0, 0, 0.1]}
  cables:
  - {name: cable_3, frame: [3.5, 2.0, 3.6]}
  - name: left
    tension: {max: 9000}
    length: {max: 11}
"""
SAID = BASE + BELIEVED


def test_the_nominal_robot_differs_only_in_given_keys():
    scenario = load(SAID)
    robot, believed = scenario.robot, scenario.nominal
    assert (robot.platform.mass, believed.platform.mass) == (150, 140)
    assert believed.platform.center_of_mass.tolist() == [0, 0, 0.1]
    assert believed.platform.inertia.tolist() == robot.platform.inertia.tolist()
    assert [cable.name for cable in believed.cables] == [cable.name for cable in robot.cables]
    anchors = robot.anchors.copy()
    anchors[2, 2] = 3.6
    assert believed.anchors.tolist() == anchors.tolist()
    assert believed.tension_max.tolist() == [9000, *robot.tension_max[1:]]
    assert believed.tension_min.tolist() == robot.tension_min.tolist()
    assert (believed.cables[0].length_min, believed.cables[0].length_max) == (0.5, 11)
    assert load(BASE).nominal is None
    assert load(BASE).nominal_differences == ""


def test_the_key_may_be_spelled_nominal():
    scenario = load(BASE + BELIEVED.replace("believed:", "nominal:"))
    assert scenario == load(SAID)
    assert scenario.with_changes({"nominal.platform.mass": 90}).nominal.platform.mass == 90
    assert load(SAID, "nominal.platform.mass=80", "nominal.cables[1].frame[2]=3.3").nominal.platform.mass == 80
    told = problem(BASE + "nominal:\n  platform: {mas: 3}\n")
    assert told.startswith(f"a.yaml:{BASE.count(chr(10)) + 2}:")
    assert "believed.platform.mas: unknown key 'mas'" in told


def test_both_spellings_of_the_key_are_one_problem():
    told = problem(SAID + "nominal: {platform: {mass: 3}}\n")
    assert "nominal: another spelling of 'believed', which is given at " in told
    assert told.endswith(": remove one of them")


def test_all_cables_may_be_given_in_their_order():
    rows = "".join(f"  - {{platform: [0.{i}, 0, 0]}}\n" for i in range(3))
    assert load(f"{BASE}believed:\n  cables:\n{rows}").nominal.anchors[:, 3].tolist() == [0.0, 0.1, 0.2]


def test_differences_are_reported_in_one_line():
    told = "platform.mass 140 kg instead of 150; platform.center_of_mass [0, 0, 0.1] m instead of [0.01, 0.02, 0.03]; "
    told += "cables.left.tension.max 9000 N instead of 9500; cables.left.length.max 11 m instead of 12; and 1 more"
    assert load(SAID).nominal_differences == told
    assert load(BASE + "believed: {}\n").nominal_differences == "the robot without changes"


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (["believed.platform.mass=100"], 100),
        (["robot.platform.mass=90"], 140),
        (["believed={}", "robot.platform.mass=90"], 90),
        (["believed.platform.mass=100", "believed={}"], 150),
        (["believed={}", "believed={platform: {mass: 7}}"], 7),
    ],
)
def test_changes_from_outside(changes, expected):
    assert load(SAID, *changes).nominal.platform.mass == expected


def test_changes_through_a_list_count_from_the_robot_in_any_order():
    changes = ["believed.cables[1].frame[2]=3.3", "robot.cables[1].frame[0]=3.4", "believed.platform.inertia[0]=7"]
    for order in (changes, changes[::-1]):
        believed = load(BASE, *order).nominal
        assert believed.cables[1].frame.tolist() == [3.4, -2.0, 3.3]
        assert believed.platform.inertia[0, 0] == 7
    again = load(BASE, changes[0]).with_changes({"robot.cables[1].frame[0]": 3.4})
    assert again.nominal.cables[1].frame.tolist() == [3.4, -2.0, 3.3]
    assert (
        again.with_changes({"believed.cables": [{"name": "left", "diameter": 0.01}]}).nominal.cables[1].frame[2] == 3.5
    )


def test_the_resolved_scenario_is_equal():
    scenario = load(SAID, "believed.cables[1].platform[1]=-0.2", "believed.cables[0].tension.min=30")
    again = load(scenario.resolved_yaml())
    assert again == scenario
    assert again.nominal_differences == scenario.nominal_differences
    assert again.nominal.anchors.tolist() == scenario.nominal.anchors.tolist()
    assert "believed" not in load(BASE).resolved_yaml()


def test_a_study_varies_it(tmp_path):
    axis = "{key: 'believed.platform.mass', values: [140, 160]}"
    study = load_study(write_study(tmp_path, f"axes:\n  - {axis}\n"))
    found = [load_scenario("case.yaml", text=case.text) for case in study.cases]
    assert [one.nominal.platform.mass for one in found] == [140, 160]
    assert len({one.robot.platform.mass for one in found}) == 1


def test_forms_are_replaced_and_not_mixed():
    assert "believed.platform.shape" in load(BASE, "believed.platform.shape={sphere: 0.3}").unused
    assert "believed.platform.tools" in load(BASE, "believed.platform.tools.nozzle=[0, 0, -0.4]").unused
    scenario = load(BASE, "robot.home={position: [0, 0, 1], orientation: {rpy: [0, 0, 0]}}", "believed={}")
    turned = scenario.with_changes({"believed.home.orientation": {"quaternion": [1, 0, 0, 0]}})
    assert turned.nominal.home.tolist() == [0, 0, 1, 1, 0, 0, 0]


def test_the_exits_of_cables_are_believed_too():
    """A pulley that is believed to be a point, and one of another radius."""
    pulleys = {"robot.cable.exit": {"type": "pulley", "radius": 0.05, "axis": [0, 1, 0]}}
    point = load_scenario(CAROCA, overrides={**pulleys, "believed.cable.exit": {"type": "point"}})
    assert [{cable.exit.type for cable in each.cables} for each in (point.robot, point.nominal)] == [
        {"pulley"},
        {"point"},
    ]
    smaller = load_scenario(CAROCA, overrides={**pulleys, "believed.cable.exit.radius": 0.04})
    assert smaller.nominal.cables[0].exit.numbers()[:4] == [0.04, 0, 1, 0]
    assert smaller.nominal_differences == "cable.exit.radius 0.04 m instead of 0.05"


@pytest.mark.parametrize(
    ("said", "line", "text"),
    [
        ("believed: caroca.yaml", 1, "believed: expected a mapping of keys of the robot (name, dof, "),
        ("believed:", 1, "believed: no value is given; give one or remove the key"),
        ("believed:\n  platform: {mas: 3}", 2, "believed.platform.mas: unknown key 'mas': did you mean 'mass'?"),
        ("believed:\n  platform:\n    mass: -3", 3, "believed.platform.mass: must be greater than 0 (kg), got -3"),
        ("believed:\n  platform:\n    mass:", 3, "believed.platform.mass: expected a number (kg), got null"),
        (
            "believed:\n  platform:\n    mass: 1,5",
            3,
            "believed.platform.mass: expected a number (kg), got '1,5'; write 1.5",
        ),
        ("believed:\n  weight: 3", 2, "believed.weight: unknown key 'weight'"),
        ("believed:\n  dof: [x, y, z]", 2, "believed.dof: must be the robot's, [x, y, z, rx, ry, rz]"),
        ("believed:\n  cables: 3", 2, "believed.cables: expected a list, got 3"),
        (
            "believed:\n  cables:\n  - 3",
            3,
            "believed.cables[0]: expected a mapping (name of a cable, and its different values)",
        ),
        ("believed:\n  cables:\n  - {frame: [1, 2, 3]}", 3, "believed.cables[0].name: required but not given: name"),
        (
            "believed:\n  cables:\n  - {name: lef}",
            3,
            "believed.cables[0].name: unknown cable 'lef': did",
        ),
        ("believed:\n  cables:\n  - name: left\n  - name: left", 4, "believed.cables[1].name: 'left' is the cable of "),
        (
            "believed:\n  cables:\n  - name: left\n    frame: [1, 2]",
            4,
            "believed.cables[0].frame: expected 3 numbers (m)",
        ),
        ("believed:\n  tension: {min: 8500}", 2, "believed.tension.min: must not exceed the highest tension of this"),
        ("believed:\n  cable: {model: rigid}", 2, "believed: cable.model rigid needs the winch of each cable"),
        (
            "believed:\n  cables:\n  - {name: cable_2, frame: [3.5, 2.0, 3.5], platform: [0.6, 0.3, -0.2]}",
            0,
            "believed.cables[2]: coincides with cables[1] at both ends",
        ),
        (
            "believed:\n  cables:\n  - {name: left, frame: [0, 0.1, 1.2], platform: [0, 0, 0]}",
            0,
            "for the nominal model: cable 'left' has no length here",
        ),
    ],
)
def test_mistakes_are_reported_at_their_source(said, line, text):
    told = problem(BASE + said + "\n")
    assert text in told
    if line:
        assert told.startswith(f"a.yaml:{BASE.count(chr(10)) + line}:")


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ("believed.platform.mass=abc", "believed.platform.mass: expected a number (kg), got 'abc'"),
        ("believed.cables[9].frame[2]=3", "believed.cables: there is no item [9]: the list has the items [0] to [2]"),
        ("believed.cables[0].name=foo", "believed.cables[0].name: must be 'left', the name of this cable of the robot"),
        ("believed.cables.left.frame=[1,2,3]", "believed.cables: expected a list, got a mapping"),
    ],
)
def test_mistakes_from_outside_name_the_change(change, text):
    assert problem(BASE, change).startswith(f"--set {change}: {text}")


def test_robot_errors_are_reported_once():
    """Values that the nominal model takes from the robot are not reported twice."""
    wrong = BASE.replace("mass: 150", "mass: abc").replace("diameter: 0.006", "diameter: -1")
    assert wrong != BASE
    told = problems(wrong + BELIEVED.replace("mass: 140, ", ""))
    assert len(told) == 2
    assert not any("believed" in each for each in told)
    both = problems(wrong + BELIEVED.replace("mass: 140", "mass: xyz"))
    assert sum("believed.platform.mass" in each for each in both) == 1
    assert len(both) == 3


def test_events_fit_both():
    """A limit that the true cable could keep contradicts the other one that is believed."""
    event = "events:\n- {type: limits, time: 0.5, max: 60, cable: cable_2}\n"
    load(BASE + event)
    told = problem(BASE + event + "believed: {tension: {min: 70}}\n")
    assert "events[0]: for the nominal model: cable 'cable_2' would have the limits 70 to 60" in told


def test_numbers_of_a_file_are_those_of_the_robot():
    scenario = load_scenario(str(ROOT / "scenarios" / "believed.yaml"))
    robot = cdpr.load_robot(str(ROOT / "scenarios" / "robots" / "caroca.yaml"))
    assert np.array_equal(scenario.robot.anchors, robot.anchors)
    assert np.count_nonzero(scenario.nominal.anchors != robot.anchors) == 2
