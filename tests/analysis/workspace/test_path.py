"""Analysis of a motion by `cdpr info`: least margin, clearance and stiffness along it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from conftest import ROOT
from workspace_cases import cli

from cdpr import load_scenario
from cdpr.analysis.workspace import answers, measure
from cdpr.analysis.workspace.path import along
from cdpr.analysis.workspace.question import Question
from cdpr.mechanics.clearance import clearance

SCENARIOS = ROOT / "scenarios"
GRAVITY = np.array([0.0, 0.0, -9.81])


def way(scenario, count=50):
    """Times (K,) and poses (K, 7) of its motion."""
    time = np.linspace(0.0, scenario.simulation.duration, count)
    return time, np.array([scenario.desired.sample(t)[:7] for t in time])


def test_they_are_the_least_of_all_samples():
    scenario = load_scenario(SCENARIOS / "winch.yaml", overrides={"robot.cable.diameter": 0.004})
    robot, (time, poses) = scenario.robot, way(scenario)
    found = along(robot, time, poses, GRAVITY)
    for name, values in {
        "margin": measure(robot, poses).value,
        "clearance": clearance(robot).at(poses)[0],
        "stiffness": answers.stiff(robot, poses, Question()).value,
    }.items():
        k = int(np.argmin(values))
        assert (found[name]["value"], found[name]["at_s"]) == (values[k], time[k])
    assert found["clearance"]["by"] == clearance(robot).name(clearance(robot).at(poses)[1][int(np.argmin(values))])


def test_unknown_stiffness_is_left_out_and_unknown_diameters_are_assumed():
    scenario = load_scenario(SCENARIOS / "caroca.yaml")
    found = along(scenario.robot, *way(scenario), GRAVITY)
    assert list(found) == ["margin", "clearance"]
    assert found["clearance"]["by"].endswith(", with an assumed cable diameter of 10 mm")
    known = load_scenario(SCENARIOS / "caroca.yaml", overrides={"robot.cable.diameter": 0.01})
    assert found["clearance"]["value"] == along(known.robot, *way(known), GRAVITY)["clearance"]["value"]
    legs = load_scenario(SCENARIOS / "caroca.yaml", overrides={"robot.unilateral": False})
    assert list(along(legs.robot, *way(legs), GRAVITY)) == ["margin"]


def test_beyond_the_workspace_the_margin_is_below_zero():
    scenario = load_scenario(SCENARIOS / "caroca.yaml")
    time, poses = way(scenario)
    poses[:, 2] = 9.0  # above all anchors: nothing holds it, but there is a margin, below 0
    found = along(scenario.robot, time, poses, GRAVITY)
    assert found["margin"]["value"] < 0.0


@pytest.mark.slow
def test_info_reports_them():
    done = cli("info", SCENARIOS / "winch.yaml", "--set", "robot.cable.diameter=0.004", "--json")
    told = json.loads(done.stdout)["motion"]["least"]
    lines = cli("info", SCENARIOS / "winch.yaml", "--set", "robot.cable.diameter=0.004").stdout
    margin, gap = told["margin"], told["clearance"]
    assert f"capacity margin      {margin['value']:.4g} N, at rest, at {margin['at_s']:.4g} s, {margin['by']}" in lines
    assert f"least clearance      {gap['value']:.4g} m at {gap['at_s']:.4g} s, {gap['by']}" in lines
    assert f"least stiffness      {told['stiffness']['value']:.4g} N/m" in lines


@pytest.mark.slow
@pytest.mark.parametrize("name", ["planar", "point_mass", "spherical", "thesis", "cogiro_pulleys"])
def test_every_kind_of_robot_is_reported(name):
    done = cli("info", SCENARIOS / f"{name}.yaml")
    assert done.returncode == 0
    assert "Traceback" not in done.stderr
