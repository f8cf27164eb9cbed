"""Suspicious values cause warnings, similar plausible ones do not: a case for every check."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from plausible_cases import CAROCA, LOW, ROBOT, SCENARIOS, WEAK, told, warned

from cdpr.scenario import load_scenario
from cdpr.scenario.plausible import CHECKS, Setup

ENCODERS = [{"type": "encoders"}]
HERE = os.path.relpath(Path(__file__).parent, SCENARIOS)


def times(cables, frame=1.0, platform=1.0):
    return [
        {"frame": [frame * x for x in cable["frame"]], "platform": [platform * x for x in cable["platform"]]}
        for cable in cables
    ]


# Suspicious value, its warning, and a similar plausible value.
CASES = [
    (
        {"sensors": [{"type": "imu", "delay": 5.0}]},
        r"sensors\[0\].delay: 5 s is longer than the run of 4 s: no measurement but the first arrives",
        {"sensors": [{"type": "imu", "delay": 3.0}]},
    ),
    (
        {"sensors": [{"type": "imu", "name": "other"}, {"type": "imu", "period": 5.0}]},
        r"sensors\[1\].period: 5 s is longer than the run of 4 s: it measures once",
        {"sensors": [{"type": "imu", "period": 3.0}]},
    ),
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
        {"initial.position": [0, 0, 1250]},  # also outside of the frame, and all cables pull downwards there
        r"initial.position: lies beyond reach: 1246 m .*: \[0, 0, 1250\] in millimetres is \[0, 0, 1.25\] m",
        {"initial.position": [0, 0, 1.25]},
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
    (
        {"world.obstacles": [{"mesh": f"{HERE}/dented.obj", "position": [2, 0, 0]}]},
        r"world.obstacles\[0\].mesh: is not convex: its convex hull counts, 0.5 m above its deepest corners",
        {"world.obstacles": [{"mesh": f"{HERE}/rough.obj", "position": [2, 0, 0]}]},
    ),
]


@pytest.mark.parametrize(("seldom", "what", "nearly"), CASES, ids=[case[1][:40] for case in CASES])
def test_suspicious_values_are_reported_and_similar_ones_are_not(seldom, what, nearly):
    found = told(warned(seldom))
    assert any(re.match(what, text) for text in found), found
    # A pose nearly out of the frame may exceed the limits, and thick cables touch: other warnings.
    others = [each for each in (WEAK, "touch here") if each not in what]
    assert [text for text in told(warned(nearly)) if not any(each in text for each in others)] == []


def test_drums_that_become_empty_along_the_motion():
    def found(growth, **more):
        changes = {"robot.winch.drum_growth": growth, **more}
        return [text for text in told(warned(changes, SCENARIOS / "winch.yaml")) if "drum" in text]

    (text,) = found(0.005)
    empty = r"at 1\.\d+ s of the motion, cable 'cable_1': its drum is empty at a length of 5\.\d+ m"
    assert re.match(rf"(--set.*: )?robot\.winch\.drum_growth: {empty}", text)
    assert not found(0.001)
    assert not found(0.005, **{"simulation.duration": 1.0})  # not reached


def test_every_check_has_a_case():
    """A check without a warning in any of these cases is dead or not tested; angles are in test_cli_words."""
    subjects = [subject(load_scenario(CAROCA, overrides=seldom)) for seldom, _, _ in CASES]
    planar = {
        "events": [{"type": "wrench", "time": 0.0, "force": [0, 5, 0]}],
        "initial.orientation": {"rpy": [0, 90, 0]},
    }
    subjects.append(subject(load_scenario(SCENARIOS / "planar.yaml", overrides=planar)))
    body = {"type": "payload", "time": 0.0, "mass": 1.0, "center": [0, 0, -1]}
    subjects.append(subject(load_scenario(SCENARIOS / "point_mass.yaml", overrides={"events": [body]})))
    subjects.append(subject(load_scenario(SCENARIOS / "gcode.yaml", overrides={"trajectory.limits.velocity": 0.1})))
    loose = {"robot.tension.min": 10}
    subjects.append(subject(load_scenario(SCENARIOS / "sagging.yaml", overrides=loose)))
    anchor = [round(a - b, 9) for a, b in zip(ROBOT["cables"][0]["frame"], ROBOT["cables"][0]["platform"], strict=True)]
    passing = {
        "initial.position": [anchor[0], anchor[1], anchor[2] - 0.5],
        "trajectory.to": {"position": [anchor[0], anchor[1], anchor[2] + 0.5], "orientation": {"rpy": [0, 0, 0]}},
    }
    subjects.append(subject(load_scenario(CAROCA, overrides=passing)))
    subjects.append(subject(load_scenario(SCENARIOS / "winch.yaml", overrides={"robot.winch.drum_growth": 0.005})))
    stepper = {"type": "stepper", "drum_radius": 1.0, "stall_torque": 10.0, "steps_per_turn": 1, "microsteps": 1}
    subjects.append(subject(load_scenario(SCENARIOS / "camera_robot.yaml", overrides={"robot.winch": stepper})))
    subjects.append(subject(load_scenario(CAROCA, overrides={"sensors": ENCODERS})))
    stretched = {"sensors": ENCODERS, "estimator": {"type": "forward_kinematics"}}
    subjects.append(subject(load_scenario(SCENARIOS / "winch.yaml", overrides=stretched)))
    assert [check.__name__ for check in CHECKS if not any(list(check(one)) for one in subjects)] == []


def subject(scenario):
    given = (scenario.sections.robot, scenario.robot, ("robot",), scenario._document.data)
    about = scenario.sections, scenario._checked.motion, scenario.obstacles, lambda: scenario.desired
    return Setup(*given, *about, False, *scenario._declared())
