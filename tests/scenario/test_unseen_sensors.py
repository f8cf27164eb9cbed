"""Warnings of sensors that nothing uses, and of estimators whose encoders measure other lengths than those assumed."""

from __future__ import annotations

import pytest
from plausible_cases import CAROCA, SCENARIOS, told, warned

ENCODERS, POSE, TWIST = {"type": "encoders"}, {"type": "pose"}, {"type": "twist"}
RECEIVER = {"type": "receiver", "name": "gps"}
IMU, LOAD_CELLS = {"type": "imu"}, {"type": "tension"}
CAMERA = {"type": "camera", "position": [0, 0, 5], "attitude": [0, 1, 0, 0]}
MARKERS = {**CAMERA, "type": "markers", "markers": [[0.5, 0, 0.2], [0, 0.5, 0.2], [-0.5, 0, 0.2]]}
NONE, EKF, FITTED = ({"type": name} for name in ("none", "ekf", "forward_kinematics"))
MIXED = {"type": "complementary"}


def found(path=CAROCA, **sections):
    return [
        text for text in told(warned(sections, path)) if "replace the true pose" in text or "straight cables" in text
    ]


@pytest.mark.parametrize("controller", ["computed_torque", "pid", "static", "sliding_mode", "adaptive"])
def test_encoders_alone_do_not_replace_the_true_pose(controller):
    (text,) = found(sensors=[LOAD_CELLS, ENCODERS], controller={"type": controller})
    assert "sensors[1]: 'encoders' does not replace the true pose" in text
    assert f"the true pose and twist, which the controller '{controller}' uses" in text
    assert "estimator: {type: ekf}" in text


def test_all_unused_sensors_are_named():
    (text,) = found(sensors=[ENCODERS, RECEIVER, MARKERS])
    assert "'encoders', 'gps' and 'markers' do not replace the true pose" in text
    (text,) = found(sensors=[{**ENCODERS, "name": f"e{i}"} for i in range(7)])
    assert "'e0', 'e1', 'e2', 'e3' and 3 more do not replace the true pose" in text


def test_sensors_besides_those_of_an_inner_loop_are_reported():
    (text,) = found(sensors=[LOAD_CELLS, ENCODERS], controller={"type": "tension_feedback"})
    assert "'encoders' does not replace the true pose" in text
    assert not found(sensors=[LOAD_CELLS], controller={"type": "tension_feedback"})


@pytest.mark.parametrize(
    "sections",
    [
        {"sensors": [CAMERA, LOAD_CELLS, IMU]},  # do not measure the pose, so that nobody expects the loop to use them
        {"sensors": [ENCODERS, POSE, TWIST]},
        {"sensors": [ENCODERS], "estimator": EKF},
        {"sensors": [ENCODERS], "estimator": NONE},  # the choice is stated
        {"sensors": [ENCODERS], "controller": {"type": "cable_length"}},
        {"sensors": [MARKERS], "controller": {"type": "visual_servo"}},
        {"sensors": [ENCODERS], "controller": {"type": "remote", "address": "127.0.0.1:5000"}},
        {"sensors": [ENCODERS], "estimator": FITTED},
    ],
)
def test_sensors_that_are_used_or_recorded_on_purpose_cause_no_warning(sections):
    assert not found(**sections)


def test_open_loops_use_no_pose():
    assert not found(SCENARIOS / "camera_robot.yaml", sensors=[ENCODERS])


@pytest.mark.parametrize(
    ("file", "what"), [("winch", "the stretch; use the estimator ekf"), ("sagging", "stretch and sag; ")]
)
def test_forward_kinematics_of_cables_that_stretch(file, what):
    path = SCENARIOS / f"{file}.yaml"
    (text,) = found(path, sensors=[ENCODERS], estimator=FITTED)
    assert "estimator.type: 'forward_kinematics' assumes straight cables" in text
    assert f"the error of the pose is about {what}" in text.replace("about the stretch and", "about stretch and")
    (text,) = found(path, sensors=[ENCODERS, IMU], estimator=MIXED)
    assert "'complementary' assumes straight cables" in text
    assert not found(path, sensors=[ENCODERS, IMU, POSE], estimator=MIXED)
    assert not found(path, sensors=[ENCODERS, LOAD_CELLS], estimator=EKF)
