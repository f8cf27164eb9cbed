"""Cables that touch are reported by `validate`, `info`, `run` and the window, with the diameter that is assumed."""

from __future__ import annotations

import json

import pytest
from command_line import cdpr_here

from cdpr.ui.gui.editor import Editor

# Mirrored at the plane x = 0, so that the cables of each pair meet in it.
CABLES = [
    {"frame": [2.0 * a, 1.5 * b, 1.25 + 1.25 * level], "platform": [-0.2 * level * a, 0.15 * level * b, -0.1 * level]}
    for level in (1, -1)
    for a in (-1, 1)
    for b in (-1, 1)
]
ROBOT = {
    "platform": {"mass": 20, "inertia": [0.2, 0.3, 0.4, 0, 0, 0], "shape": {"box": [0.4, 0.3, 0.2]}},
    "tension": {"min": 10, "max": 400},
    "home": {"position": [0, 0, 1.25]},
    "cables": CABLES,
}
TOUCH = "touch here: their clearance is -{} mm"
ASSUMED = "with an assumed cable diameter of 10 mm"


@pytest.fixture
def scenario(tmp_path):
    (tmp_path / "robot.yaml").write_text(json.dumps(ROBOT))
    data = {"robot": "robot.yaml", "simulation": {"duration": 0.02, "control_step": 0.001}}
    (tmp_path / "scenario.yaml").write_text(json.dumps(data))
    return tmp_path / "scenario.yaml"


def test_touching_cables_are_reported_with_the_assumed_diameter(scenario):
    robot = scenario.with_name("robot.yaml")
    said = cdpr_here("validate", robot).stderr
    assert "home.position: cable_" in said  # which of four pairs, round-off decides
    assert f"{TOUCH.format(10)}, {ASSUMED}" in said
    assert "m: TOUCHING, cable_" in cdpr_here("info", robot).stdout
    told = cdpr_here("validate", scenario, "--set", "robot.cable.diameter=0.004").stderr
    assert TOUCH.format(4) in told
    assert "assumed" not in told
    cdpr_here("validate", robot, "--strict", code=2)


def test_the_window_reports_them_too(scenario):
    (warning,) = Editor(str(scenario)).form()["warnings"]
    assert warning["path"] == "robot.home.position"
    assert f"{TOUCH.format(10)}, {ASSUMED}" in warning["text"]


def test_a_run_reports_cables_that_touch(scenario):
    done = cdpr_here("run", scenario, "--out", scenario.with_name("run"), "--no-report")
    assert "touch: their clearance falls to -10 mm at " in done.stdout
    assert ASSUMED in done.stdout
    figures = cdpr_here("run", scenario, "--out", scenario.with_name("more"), "--json")
    assert ASSUMED in (scenario.with_name("more") / "report.html").read_text()
    assert ASSUMED in json.loads(figures.stdout)["reservations"][-1]


def test_cable_through_the_platform_has_no_depth(scenario):
    """A cable leaves the top face 1 mm from its edge and goes down: its other end is 1.35 m below that face."""
    robot = json.loads(scenario.with_name("robot.yaml").read_text())
    robot["cables"][4] = {"frame": [-2, -1.5, 0], "platform": [-0.199, 0.149, 0.1]}
    scenario.with_name("robot.yaml").write_text(json.dumps(robot))
    through = "cable_5 passes through the platform"
    assert f"home.position: {through}, {ASSUMED}" in cdpr_here("validate", scenario).stderr
    assert f"none: {through}, {ASSUMED}" in cdpr_here("info", scenario).stdout
    run = cdpr_here("run", scenario, "--out", scenario.with_name("run"), "--no-report").stdout
    assert f"WARNING             {through} at 0" in run
    changes = "--set", "robot.cable.diameter=0.01", "--set"
    watched = "events=[{type: contact}]"
    figured = cdpr_here("run", scenario, *changes, watched, "--out", scenario.with_name("watched")).stdout
    assert f"least clearance     none: {through} at 0" in figured
    assert f": {through} at 0" in figured
    assert f"none: {through} at 0" in (scenario.with_name("watched") / "report.html").read_text()
    watched = "events=[{type: contact, then: stop}]"
    done = cdpr_here("run", scenario, *changes, watched, "--out", scenario.with_name("stop"), "--no-report", code=4)
    assert f"{through}; stopped by the scenario where they touch" in done.stdout + done.stderr
    assert "-1." not in run + figured + done.stdout
