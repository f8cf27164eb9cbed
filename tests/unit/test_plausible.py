"""What is allowed and seldom meant is told, and what is only unusual is not."""

from __future__ import annotations

import json
import re
import time

import numpy as np
import pytest
import yaml
from command_line import cdpr_here
from conftest import ROOT

from cdpr.errors import CdprError, PluginError, ScenarioError
from cdpr.log.run import Run
from cdpr.report.text.reservations import lost
from cdpr.scenario import load_any, load_scenario
from cdpr.scenario.plausible import CHECKS, Setup

SCENARIOS = ROOT / "scenarios"
CAROCA = SCENARIOS / "caroca.yaml"
FILES = sorted([*SCENARIOS.glob("*.yaml"), *(SCENARIOS / "robots").glob("*.yaml")])
ROBOT = yaml.safe_load((SCENARIOS / "robots" / "caroca.yaml").read_text())
LOW = [{**cable, "frame": [*cable["frame"][:2], 0.0]} for cable in ROBOT["cables"]]  # all from the floor


def warned(changes, path=CAROCA):
    return load_scenario(path, overrides=changes).warnings


def told(rows):
    return [f"{row}".partition(": ")[2] for row in rows]


def times(cables, frame=1.0, platform=1.0):
    return [
        {"frame": [frame * x for x in cable["frame"]], "platform": [platform * x for x in cable["platform"]]}
        for cable in cables
    ]


WEAK = "no tensions within the limits hold the platform's weight"

# Published starts at which the cables cannot hold the platform up, as the files' first comments say.
UNHELD = {SCENARIOS / "thesis.yaml", SCENARIOS / "thesis_ch6.yaml"}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_nothing_is_said_of_what_ships(path):
    rows = []
    load_any(path, warnings=rows)
    known = [f"initial.position: {WEAK} here"]
    assert [text.rpartition(": ")[0] for text in told(rows)] == known * (path in UNHELD)


def box(width, *, mass=20.0, platform=0.1, inertia=None, **more):
    """A robot in a cube with cables from all corners to a small cube, crossed: all sizes follow from these."""
    half, small = 0.5 * width, 0.5 * platform * width
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    cables = [
        {"frame": (half * s + [0, 0, half]).tolist(), "platform": (small * s * [1, 1, -1]).tolist()} for s in signs
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


def test_nothing_is_said_of_a_lift_on_one_cable(tmp_path):
    """Its one anchor has no extent."""
    lift = box(2.0) | {"dof": ["z"], "cables": [{"frame": [0, 0, 3], "platform": [0, 0, 0.2]}]}
    assert robot_warnings(lift, tmp_path) == []


# FAST: cables of 300 m to a cabin of 30 t; a camera of 0.3 m above a stadium; a robot of a desk; an insect's.
@pytest.mark.parametrize(
    ("width", "mass", "platform"),
    [(600, 3e4, 0.02), (200, 15, 0.0015), (0.2, 0.1, 0.2), (0.02, 1e-3, 0.3), (4, 1e4, 0.9)],
)
def test_nothing_is_said_of_large_and_small_robots(width, mass, platform, tmp_path):
    assert robot_warnings(box(width, mass=mass, platform=platform), tmp_path) == []


@pytest.mark.parametrize(("width", "mass", "platform"), [(8, 100, 0.15), (0.2, 0.1, 0.2), (600, 3e4, 0.02)])
def test_a_robot_in_millimetres_is_told_whatever_its_size(width, mass, platform, tmp_path):
    """With a mass and an inertia in kg and kg m^2."""
    right = box(width, mass=mass, platform=platform)
    wrong = box(1000 * width, mass=mass, platform=platform, inertia=right["platform"]["inertia"])
    assert any("in metres" in text or "kg, m and kg m^2" in text for text in told(robot_warnings(wrong, tmp_path)))


# What is seldom meant, what is told of it, and what is nearly so.
CASES = [
    (
        {"robot.cables": times(ROBOT["cables"], frame=1000.0)},
        r"robot.cables: the frame's anchors are 8062 m apart; lengths are in metres: in millimetres that is 8.062 m",
        {"robot.cables": times(ROBOT["cables"], frame=300.0)},
    ),
    (
        {"robot.cables": times(ROBOT["cables"], platform=1000.0)},
        r"robot.cables: the platform's anchors are 1400 m apart, those on the frame 8.062 m; .* 1.4 m",
        {"robot.cables": times(ROBOT["cables"], platform=19.0), "robot.home.position": [0, 0, 1.1]},
    ),
    (
        {"robot.cables": times(ROBOT["cables"], frame=350.0, platform=0.9)},
        r"robot.cables: the frame's anchors are 2822 m apart, those on the platform 1.26 m; .* 2.822 m",
        {"robot.cables": times(ROBOT["cables"], frame=300.0)},
    ),
    (
        {"robot.platform.inertia": [6.5e6, 2e7, 2.25e7, 0, 0, 0]},
        r"robot.platform.inertia: a body of 150 kg with this inertia is some 387 m large, and its cables end 0.7 m",
        {"robot.platform.inertia": [6.5e5, 2e6, 2.25e6, 0, 0, 0]},
    ),
    (
        {"robot.platform.shape": {"box": [1200, 600, 400]}},
        r"robot.platform.shape: of 2.88e\+08 m\^3 a body of 150 kg would be lighter than air",
        {"robot.platform.shape": {"box": [120, 60, 40]}},
    ),
    (
        {"robot.platform.shape": {"sphere": 300}},
        r"robot.platform.shape: of 1.13e\+08 m",
        {"robot.platform.shape": {"sphere": 60}},
    ),
    (
        {"robot.platform.shape": {"cylinder": {"radius": 300, "height": 200}}},
        r"robot.platform.shape: of 5.65e\+07 m",
        {"robot.platform.shape": {"cylinder": {"radius": 30, "height": 200}}},
    ),
    (
        {"robot.cable.diameter": 4},
        r"robot.cable.diameter: a cable 4 m thick; lengths are in metres: in millimetres 0.004 m",
        {"robot.cable.diameter": 0.3},
    ),
    ({"robot.cables[2].diameter": 4}, r"robot.cables\[2\].diameter: a cable 4 m", {"robot.cables[2].diameter": 0.3}),
    (
        {"robot.winch": {"drum_radius": 50, "inertia": 1}},
        r"robot.winch.drum_radius: a drum of 50 m; .* 0.05 m",
        {"robot.winch": {"drum_radius": 5, "inertia": 1}},
    ),
    (
        {"robot.cables[1].winch": {"drum_radius": 50, "inertia": 1}},
        r"robot.cables\[1\].winch.drum_radius: a drum of 50 m",
        {"robot.cables[1].winch": {"drum_radius": 5, "inertia": 1}},
    ),
    (
        {"robot.home.position": [-4.1, -1.7, 3.7]},
        r"robot.home.position: cable 'cable_1' has no length here",
        {"robot.home.position": [-3.5, -1.7, 3.4]},
    ),
    (
        {"robot.cables": LOW},
        r"robot.home.position: all 8 cables pull the platform along \[.*\] \(x, y, z\) here, and nothing pulls it",
        {"robot.cables": [*LOW[:7], ROBOT["cables"][7]]},
    ),
    (
        {"initial.position": [3.6, 0, 1.2]},
        r"initial.position: lies outside the frame: its anchors go from x = -3.5",
        {"initial.position": [3.5, 0, 1.2]},
    ),
    (
        {"trajectory.to.position": [0, 0, 3.8]},
        r"trajectory.to.position: lies outside .* z = 3.5 to 3.5 m, and here z = 3.8 m",
        {"initial.position": [0, 0, -9.0]},
    ),
    (
        {"trajectory.to.position": [1.5, 2.5, 1.6]},
        r"trajectory.to.position: lies outside the frame: its anchors go from y = -2 to 2 m",
        {"trajectory.to.position": [1.5, 2.0, 1.6]},
    ),
    (
        {"events": [{"type": "target", "time": 1, "position": [0, 0, 160], "duration": 1}]},
        r"events\[0\].position: lies outside the frame",
        {"events": [{"type": "target", "time": 1, "position": [0, 0, 1.6], "duration": 1}]},
    ),
    (
        {"trajectory": {"type": "circle", "center": [3.0, 0, 1.2], "duration": 4}},
        r"trajectory.center: lies outside the frame: .* and here y = -2.59808 m",
        {"trajectory": {"type": "circle", "center": [1.0, 0, 1.2], "duration": 4}},
    ),
    (
        {"initial.position": [0, 0, -1200]},
        r"initial.position: lies beyond reach: 1204 m from the middle",
        {"initial.position": [0, 0, -390]},
    ),
    (
        {"robot.cables[0].length": {"max": 6.4}},
        r".*position: lies beyond reach: cable 'cable_1' would be 6.49478 m long, longer than its length.max, 6.4 m",
        {"robot.cables[0].length": {"max": 6.5}},
    ),
    (
        {"robot.cables[6].length": {"min": 2.7}},
        r".*position: lies beyond reach: cable 'cable_7' would be 2.69637 m long, shorter than its length.min, 2.7",
        {"robot.cables[6].length": {"min": 2.69}},
    ),
    (
        {"world.gravity": [0, 0, 9.81]},
        r"world.gravity: points upwards, 9.81 m/s\^2 along z: .* \[0, 0, -9.81\]",
        {"world.gravity": [0, 0.1, -9.81]},
    ),
    (
        {"world.gravity": [0, 0, -9810]},
        r"world.gravity: 9810 m/s\^2 is 1000 times that of the earth",
        {"world.gravity": [0, 0, -24.8]},
    ),
    (
        {"events": [{"type": "cable_break", "time": 4.1, "cable": 1}]},
        r"events\[0\]: happens at 4.1 s, after the end of the run at 4 s: never",
        {"events": [{"type": "cable_break", "time": 4.0, "cable": 1}]},
    ),
    (
        {"trajectory.start": 4.0},
        r"trajectory.start: the motion begins at 4 s, after the run",
        {"trajectory.start": 3.9, "trajectory.duration": 0.1},
    ),
    (
        {"trajectory.duration": 4.5},
        r"simulation.duration: the run ends at 4 s and the motion at 4.5 s: the rest of it is cut off",
        {"trajectory.duration": 4.0},
    ),
    (
        {"robot.tension.max": 180},
        rf"robot.home.position: {WEAK} here: the nearest leave 762 N of 1472 N",
        {"robot.tension.max": 400},
    ),
]


@pytest.mark.parametrize(("seldom", "what", "nearly"), CASES, ids=[case[1][:40] for case in CASES])
def test_what_is_seldom_meant_is_told_and_what_is_nearly_so_is_not(seldom, what, nearly):
    found = told(warned(seldom))
    assert any(re.match(what, text) for text in found), found
    # What is nearly out of the frame may be more than limits hold, which is another thing.
    assert [text for text in told(warned(nearly)) if WEAK in what or WEAK not in text] == []


def test_every_check_has_a_case():
    """One that yields nothing for any of these is either dead or not tested; those of angles are in test_cli_words."""
    subjects = [subject(load_scenario(CAROCA, overrides=seldom)) for seldom, _, _ in CASES]
    planar = {
        "events": [{"type": "wrench", "time": 0.0, "force": [0, 5, 0]}],
        "initial.orientation": {"rpy": [0, 90, 0]},
    }
    subjects.append(subject(load_scenario(SCENARIOS / "planar.yaml", overrides=planar)))
    assert [check.__name__ for check in CHECKS if not any(list(check(one)) for one in subjects)] == []


def subject(scenario):
    given = (scenario.sections.robot, scenario.robot, ("robot",), scenario._document.data)
    return Setup(*given, scenario.sections, scenario._motion)


def test_a_position_in_a_file_is_told(tmp_path):
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


def test_without_weight_only_tensions_out_of_balance_are_told():
    """Round-off among large tensions is none, whatever the weight."""
    planar = SCENARIOS / "planar.yaml"
    for gravity in ([0, 0, 0], [0, 0, -1e-14]):
        assert warned({"world.gravity": gravity, "robot.tension": {"min": 1e5, "max": 1e8}}, planar) == ()
    uneven = {"world.gravity": [0, 0, 0], "robot.tension": {"min": [10, 10, 900, 900], "max": 1000}}
    (row, *_) = warned(uneven, planar)
    assert re.search(
        r"no tensions within the limits are in balance here: the nearest leave [\d.]+ N, moments", row.text
    )


def test_only_directions_that_are_free_tell():
    """A table on a ball stands above all its anchors, a carriage between its two runs where its rail is."""
    spherical = SCENARIOS / "spherical.yaml"
    assert warned({"robot.cables[0].frame": [0.383, 0.321, 0.01]}, spherical) == ()
    carriage = SCENARIOS / "carriage.yaml"
    away = {"initial.position": [0, 40, 0.5], "trajectory.to.position": [1, 40, 0.5]}
    assert warned(away, carriage) == ()
    (row,) = warned({"initial.position": [-3.1, 0, 0.5]}, carriage)
    assert "all 2 cables pull the platform along [1, 0, 0]" in row.text


def test_a_pulley_is_not_its_anchor():
    """Beside it the cable leaves, so little beyond the anchors is nothing to tell; much is."""
    pulleys = {"robot.cable.exit": {"type": "pulley", "radius": 0.1, "axis": [0, 0, 1]}}
    assert warned({"trajectory.to.position": [3.55, 0, 1.2]})
    assert warned({"trajectory.to.position": [3.55, 0, 1.2]} | pulleys) == ()
    assert warned({"trajectory.to.position": [4.5, 0, 1.2]} | pulleys)
    assert warned({"robot.cables[0].length": {"max": 6.4}} | pulleys) == ()  # the arc counts, too: the run tells


def test_checks_are_quick():
    """Beside loading the same file, which every command does."""
    many = {"type": "waypoints", "points": [{"time": 0.01 * k + 1, "position": [0, 0, 1.2]} for k in range(300)]}
    begin = time.perf_counter()
    scenario = load_scenario(CAROCA, overrides={"trajectory": many})
    loaded = time.perf_counter()
    assert scenario.warnings == ()
    assert time.perf_counter() - loaded < loaded - begin


def test_what_the_controller_believes_is_told_apart():
    (row,) = warned({"believed.platform.inertia": [6.5e6, 2e7, 2.25e7, 0, 0, 0]})
    assert row.path == ("believed", "platform", "inertia")
    both = warned({"robot.cable.diameter": 4, "believed.platform.mass": 140})
    assert [row.path for row in both] == [("robot", "cable", "diameter")]  # once, not for the believed robot again


def test_places_are_those_of_the_values():
    scenario = load_scenario(CAROCA, overrides=["robot.cable.diameter=4"])
    (row,) = scenario.warnings
    assert f"{row}".startswith("--set robot.cable.diameter=4: robot.cable.diameter: a cable")
    text = CAROCA.read_text().replace("position: [1.5, 0.5, 1.6]", "position: [1500, 500, 1600]")
    (row,) = load_scenario(CAROCA, text=text).warnings
    line = 1 + next(i for i, each in enumerate(text.splitlines()) if "1500" in each)
    assert (row.mark.source, row.mark.line, row.path) == (str(CAROCA), line, ("trajectory", "to", "position"))


WRONG = ("--set", "initial.position=[3.6,0,1.2]")


@pytest.mark.parametrize("command", ["validate", "run", "info"])
def test_commands_tell_and_refuse(command, tmp_path):
    short = ("--set", "simulation.duration=0.01", "--no-report") if command == "run" else ()
    done = cdpr_here(command, CAROCA, *WRONG, *short, cwd=tmp_path)
    assert done.stderr.startswith(
        "warning: --set initial.position=[3.6,0,1.2]: initial.position: lies outside the frame"
    )
    done = cdpr_here(command, CAROCA, *WRONG, *short, "--strict", cwd=tmp_path, code=2)
    assert "initial.position: lies outside the frame" in done.stderr
    assert "warning" not in done.stderr
    assert done.stdout == ""
    if command == "validate":
        cdpr_here(command, *(path for path in FILES if path not in UNHELD), "--strict", cwd=tmp_path)


def test_warnings_in_json(tmp_path):
    (row,) = json.loads(cdpr_here("validate", CAROCA, *WRONG, "--json", cwd=tmp_path).stdout)
    (warning,) = row["warnings"]
    assert warning["key"] == "initial.position"
    assert set(warning) == {"source", "line", "column", "key", "text"}
    (row,) = json.loads(cdpr_here("validate", CAROCA, *WRONG, "--json", "--strict", cwd=tmp_path, code=2).stdout)
    assert not row["ok"]
    assert row["rows"] == [warning]


def test_an_event_after_the_end_is_told_once(tmp_path):
    late = ("--set", "events=[{type: cable_break, time: 9, cable: 1}]")
    done = cdpr_here("validate", CAROCA, *late, "--json", cwd=tmp_path)
    (row,) = json.loads(done.stdout)
    assert [warning["key"] for warning in row["warnings"]] == ["events[0]"]
    assert (row["unused"], row["notes"]) == ([], [])
    assert done.stderr.count("events[0]: happens at 9 s, after the end") == 1


def test_compare_tells_and_refuses(tmp_path):
    done = cdpr_here("compare", CAROCA, *WRONG, "--strict", "--out", tmp_path / "it", cwd=tmp_path, code=2)
    assert "initial.position: lies outside the frame" in done.stderr
    assert (done.stdout, list(tmp_path.iterdir())) == ("", [])  # nothing has run
    done = cdpr_here("compare", tmp_path, tmp_path, "--strict", cwd=tmp_path, code=2)
    assert "leave out" in done.stderr


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


def test_a_platform_that_ends_far_away_is_told(tmp_path):
    from cdpr import simulate

    run = simulate(CAROCA, overrides={"simulation.duration": 0.01})
    size = np.linalg.norm([7.0, 4.0, 2.3])  # m, of the box around anchors and start
    assert list(lost(run)) == []
    for share, count in ((0.999, 0), (1.001, 1)):
        rows = run.rows.copy()
        rows[-1, run.header.layout.columns["position"]] = run.desired_position[-1] + [share * size, 0, 0]
        assert len(list(lost(Run(run.header, rows, "finished", "")))) == count
    wrong = ("controller.kp=0", "controller.kd=0", "solver.type=pseudo_inverse")
    push = "events=[{type: wrench, time: 0, force: [30000, 0, 0]}]"
    words = [word for text in (*wrong, push, "simulation.duration=1.0") for word in ("--set", text)]
    done = cdpr_here("run", CAROCA, *words, "--no-report", cwd=tmp_path)
    assert "WARNING             the platform ends" in done.stdout
    done = cdpr_here("run", CAROCA, *words, "--no-report", "--strict", "--json", cwd=tmp_path, code=2)
    assert "stopped: the platform ends" in done.stderr
    assert any("more than the robot's size" in text for text in json.loads(done.stdout)["reservations"])
