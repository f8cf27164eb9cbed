"""Warnings are reported at their place; merely unusual values cause none."""

from __future__ import annotations

import json
import re
import sys

import numpy as np
import pytest
from plausible_cases import CAROCA, FILES, LOW, SCENARIOS, UNHELD, WEAK, told, warned

from cdpr.base.errors import CdprError, PluginError, ScenarioError
from cdpr.scenario import load_any, load_scenario


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_no_warnings_of_shipped_files(path):
    rows = []
    load_any(path, warnings=rows)
    known = [f"initial.position: {WEAK} here"]
    assert [text.rpartition(": ")[0] for text in told(rows)] == known * (path in UNHELD)


def box(width, *, mass=20.0, platform=0.1, inertia=None, **more):
    """A robot in a cube with cables from all corners to a small cube, crossed in height: sizes follow from these."""
    half, small = 0.5 * width, 0.5 * platform * width
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    shares = {1: [1, 0.25, -1], -1: [0.25, 1, -1]}  # of upper and lower cables, so that they do not touch
    cables = [
        {"frame": (half * s + [0, 0, half]).tolist(), "platform": (small * s * shares[s[2]]).tolist()} for s in signs
    ]
    moment = mass * (platform * width) ** 2 / 6.0
    body = {"mass": mass, "inertia": inertia or [moment] * 3 + [0, 0, 0], "shape": {"box": [2.0 * small] * 3}}
    home = {"position": [0, 0, half]}
    return {
        "platform": body,
        "tension": {"min": min(1, mass), "max": 10 * max(100, mass)},
        "home": home,
        "cables": cables,
        **more,
    }


def robot_warnings(data, tmp_path):
    file = tmp_path / "robot.yaml"
    file.write_text(json.dumps(data))
    rows = []
    load_any(file, warnings=rows)
    return rows


def test_no_warning_of_a_lift_on_one_cable(tmp_path):
    """Its one anchor has no extent."""
    lift = box(2.0) | {"dof": ["z"], "cables": [{"frame": [0, 0, 3], "platform": [0, 0, 0.2]}]}
    assert robot_warnings(lift, tmp_path) == []


# FAST: cables of 300 m to a cabin of 30 t; a camera of 0.3 m above a stadium; a robot of a editor; an insect's.
@pytest.mark.parametrize(
    ("width", "mass", "platform"),
    [(600, 3e4, 0.02), (200, 15, 0.0015), (0.2, 0.1, 0.2), (0.02, 1e-3, 0.3), (4, 1e4, 0.9)],
)
def test_no_warning_of_large_and_small_robots(width, mass, platform, tmp_path):
    assert robot_warnings(box(width, mass=mass, platform=platform), tmp_path) == []


@pytest.mark.parametrize(("width", "mass", "platform"), [(8, 100, 0.15), (0.2, 0.1, 0.2), (600, 3e4, 0.02)])
def test_a_robot_in_millimetres_is_reported_whatever_its_size(width, mass, platform, tmp_path):
    """With a mass and an inertia in kg and kg m^2."""
    right = box(width, mass=mass, platform=platform)
    wrong = box(1000 * width, mass=mass, platform=platform, inertia=right["platform"]["inertia"])
    texts = [text for text in told(robot_warnings(wrong, tmp_path)) if "m apart" in text or "from its origin" in text]
    assert texts
    assert all("in millimetres" in text for text in texts)


def test_a_small_robot_in_millimetres_without_inertia_is_reported(tmp_path):
    """Frame and platform are in proportion, and the frame is not larger than all existing ones."""
    wrong = box(500, platform=0.2, mass=2.0)
    del wrong["platform"]["inertia"], wrong["platform"]["shape"]
    wrong["dof"] = ["x", "y", "z"]
    text = "the platform's anchors are 173.2 m apart, those on the frame 866 m; lengths are in metres"
    assert f"{text}: in millimetres that is 0.1732 m and 0.866 m" in str(told(robot_warnings(wrong, tmp_path)))


def test_a_position_in_a_file_is_reported(tmp_path):
    rows = "t,x,y,z\n0,0,0,1.2\n1,0.5,0,{}\n2,0,0,1.2\n"
    for name in ("caroca.yaml", "robots/caroca.yaml"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text((SCENARIOS / name).read_text())
    for height, count in (("1.3", 0), ("1300", 1)):
        (tmp_path / "path.csv").write_text(rows.format(height))
        found = warned({"trajectory": {"type": "csv", "file": "path.csv"}}, tmp_path / "caroca.yaml")
        assert [row.path for row in found] == [("trajectory", "file")] * count


def test_a_load_may_hold_what_gravity_does_not():
    up = {"type": "wrench", "time": 0, "force": [0, 0, 5000]}
    low = {"robot.cables": LOW}
    assert warned(low)
    assert warned(low | {"events": [up]}) == ()
    assert warned({"robot.unilateral": False, **low}) == ()


def test_a_motion_that_loses_nothing_is_not_cut_short():
    assert warned({"trajectory.duration": 4.0009}) == ()
    (row,) = warned({"trajectory.duration": 4.001})
    assert "at 4 s and the motion at 4.001 s" in row.text


def test_limits_that_change_at_the_start_are_those_that_hold():
    weak, wider = {"robot.tension.max": 180}, {"type": "limits", "time": 0, "max": 1000}
    assert WEAK in warned(weak)[0].text
    assert warned(weak | {"events": [wider]}) == ()
    assert WEAK in warned(weak | {"events": [wider | {"time": 1.0}]})[0].text


def test_without_weight_only_tensions_out_of_balance_are_reported():
    """Round-off among large tensions is none, whatever the weight."""
    planar = SCENARIOS / "planar.yaml"
    for gravity in ([0, 0, 0], [0, 0, -1e-14]):
        assert warned({"world.gravity": gravity, "robot.tension": {"min": 1e5, "max": 1e8}}, planar) == ()
    uneven = {"world.gravity": [0, 0, 0], "robot.tension": {"min": [10, 10, 900, 900], "max": 1000}}
    (row, *_) = warned(uneven, planar)
    assert re.search(
        r"no tensions within the limits are in balance here: the nearest leave [\d.]+ N, moments", row.text
    )


def test_only_free_directions_count():
    """A table on a ball is above all its anchors, a carriage is between its two runs, along its rail."""
    spherical = SCENARIOS / "spherical.yaml"
    assert warned({"robot.cables[0].frame": [0.383, 0.321, 0.01]}, spherical) == ()
    carriage = SCENARIOS / "carriage.yaml"
    away = {"initial.position": [0, 40, 0.5], "trajectory.to.position": [1, 40, 0.5]}
    assert warned(away, carriage) == ()
    row, passing = warned({"initial.position": [-3.1, 0, 0.5]}, carriage)
    assert "passes its anchor" in passing.text  # on its way in
    assert "all 2 cables pull the platform along [1, 0, 0]" in row.text


def test_a_pulley_is_not_its_anchor():
    """The cable leaves beside it, so a small overhang causes no warning; a large one does."""
    pulleys = {"robot.cable.exit": {"type": "pulley", "radius": 0.1, "axis": [0, 0, 1]}}
    assert warned({"trajectory.to.position": [3.55, 0, 1.2]})
    assert warned({"trajectory.to.position": [3.55, 0, 1.2]} | pulleys) == ()
    assert warned({"trajectory.to.position": [4.5, 0, 1.2]} | pulleys)
    assert warned({"robot.cables[0].length": {"max": 6.4}} | pulleys) == ()  # the arc counts, too: the run shows it


def test_checks_are_quick():
    """Beside loading the same file, which every command does: counted in calls, which no other process delays."""
    many = {"type": "waypoints", "points": [{"time": 0.01 * k + 1, "position": [0, 0, 1.2]} for k in range(300)]}
    calls = [0]

    def count(frame, event, argument):
        calls[-1] += event in ("call", "c_call")

    sys.setprofile(count)
    try:
        scenario = load_scenario(CAROCA, overrides={"trajectory": many})
        calls.append(0)
        warnings = scenario.warnings
    finally:
        sys.setprofile(None)
    assert warnings == ()
    loading, looking = calls
    assert 1000 < looking < loading


def test_nominal_values_are_listed_separately():
    (row,) = warned({"believed.platform.inertia": [6.5e6, 2e7, 2.25e7, 0, 0, 0]})
    assert row.path == ("believed", "platform", "inertia")
    both = warned({"robot.cable.diameter": 4, "believed.platform.mass": 140})
    assert [row.path for row in both] == [("robot", "cable", "diameter")]  # once, not for the believed robot again


def test_places_are_those_of_the_values():
    scenario = load_scenario(CAROCA, overrides=["robot.cable.diameter=4"])
    (row,) = scenario.warnings
    assert f"{row}".startswith("--set robot.cable.diameter=4: robot.cable.diameter: a cable")
    text = CAROCA.read_text().replace("position: [1.5, 0.5, 1.6]", "position: [1500, 500, 1600]")
    row, *_ = load_scenario(CAROCA, text=text).warnings  # on its way a cable passes an axis
    line = 1 + next(i for i, each in enumerate(text.splitlines()) if "1500" in each)
    assert (row.mark.source, row.mark.line, row.path) == (str(CAROCA), line, ("trajectory", "to", "position"))


def test_errors_keep_the_rows_of_what_is_wrong():
    wrong = ["robot.platform.mass=-1", "simulation.backend=bullet_train", "initial.positon=[0,0,1]"]
    with pytest.raises(ScenarioError) as caught:
        load_scenario(CAROCA, overrides=wrong)
    assert [str(row) for row in caught.value.rows] == caught.value.problems
    assert {row.path for row in caught.value.rows} == {
        ("robot", "platform", "mass"),
        ("simulation", "backend"),
        ("initial", "positon"),
    }
    with pytest.raises(PluginError) as missing:
        load_scenario(CAROCA, overrides=wrong[1:2])
    assert [row.path for row in missing.value.rows] == [("simulation", "backend")]
    assert CdprError("anything").rows == ()


def test_a_body_whose_centre_and_inertia_have_no_effect():
    """The platform does not rotate: only the mass counts."""
    body = {"type": "payload", "time": 1.0, "mass": 2.0, "center": [0, 0, -1]}
    path = SCENARIOS / "point_mass.yaml"
    (row,) = warned({"events": [body]}, path)
    assert row.path == ("events", 0)
    assert row.text == (
        "the centre of mass of the body has no effect: the robot moves along x, y, z and does not rotate"
    )
    (row,) = warned({"events": [body | {"inertia": [1, 1, 1, 0, 0, 0]}]}, path)
    assert row.text.startswith("the centre of mass and inertia of the body")
    assert warned({"events": [body | {"center": [0, 0, 0]}]}, path) == ()
    assert warned({"events": [body]}) == ()
