"""Checks of the events of sensors, and believed values of sensors."""

from __future__ import annotations

import pytest

import cdpr
from cdpr.base.errors import CdprError, ScenarioError
from cdpr.simulation import estimation

SENSORS = [
    {"type": "pose", "name": "mocap"},
    {"type": "twist"},
    {"type": "receiver", "antenna": [0.1, 0.0, 0.2], "position": {"noise": 0.02}},
    {"type": "imu"},
]
LENS = {"type": "markers", "position": [0.0, 0.0, 1.0], "markers": [[0.0, 0.0, 1.0]]}


def load(sensors=SENSORS, **events):
    given = {"events": [{"time": 1.0, **events}]} if events else {}
    return cdpr.load_scenario("caroca", overrides={"sensors": sensors, **given})


@pytest.mark.parametrize(
    ("event", "text"),
    [
        ({"type": "sensor_failure", "sensor": "mocop"}, "unknown sensor 'mocop': did you mean 'mocap'"),
        ({"type": "sensor_failure", "sensor": "imu", "duration": 1e-4}, "duration: must be at least control_step"),
        ({"type": "sensor_occlusion", "sensor": "imu"}, "duration: required"),
        ({"type": "sensor_bump", "sensor": "imu"}, "expected at least one of position"),
        ({"type": "sensor_bump", "sensor": "imu", "quantity": "force", "position": [0, 0, 1]}, "quantity without bias"),
        ({"type": "sensor_bump", "sensor": "mocap", "position": [0, 0, 1]}, "position: sensor 'mocap' .* has no mount"),
        ({"type": "sensor_bump", "sensor": "receiver", "rotation": [0, 0, 1]}, "rotation: .*mount with axes"),
        ({"type": "sensor_bump", "sensor": "imu", "bias": [1, 2]}, "bias: expected one number, or 3 numbers, got 2"),
        ({"type": "sensor_bump", "sensor": "imu", "bias": 1, "quantity": "forze"}, "unknown quantity 'forze': did you"),
        (
            {"type": "sensor_bump", "sensor": "markers", "bias": 1, "quantity": "seen"},
            "quantity 'seen': allowed: pixel",
        ),
    ],
)
def test_impossible_events_are_reported(event, text):
    with pytest.raises(ScenarioError, match=text):
        load([*SENSORS, LENS], **event)


CAMERA = {"type": "camera", "position": [0.0, 0.0, 5.0]}


def test_the_default_period_of_a_camera_is_checked():
    steps = {"simulation.control_step": 0.004, "simulation.physics_step": 0.001, "sensors": [CAMERA]}
    with pytest.raises(ScenarioError, match=r"period: must be an integer multiple of control_step, 0\.004"):
        cdpr.load_scenario("caroca", overrides=steps)


@pytest.mark.parametrize("kind", [{}, {"type": "none"}])
def test_the_measured_state_has_no_start(kind):
    start = {"estimator": {**kind, "start": {"position": [0.0, 0.0, 1.0]}}}
    with pytest.raises(ScenarioError, match="start: the estimator `none` has no start"):
        cdpr.load_scenario("caroca", overrides={"sensors": SENSORS[:2], **start})


def test_events_need_sensors():
    with pytest.raises(ScenarioError, match="the scenario has no `sensors`"):
        load([], type="sensor_failure", sensor="imu")


def test_believed_values_replace_the_true_ones():
    believed = {"antenna": [0.1, 0.0, 0.25], "position": {"bias": 0.01}}
    (true,) = load([{**SENSORS[2], "believed": believed}]).sections.sensors
    assert true.antenna == (0.1, 0.0, 0.2)
    assert true.position.bias == 0.0
    nominal = true.nominal
    assert (nominal.title, nominal.antenna) == ("receiver", (0.1, 0.0, 0.25))
    assert (nominal.position.noise, nominal.position.bias) == (0.02, 0.01)
    assert nominal.nominal is nominal
    assert load(SENSORS).sections.sensors[0].nominal is not None
    changed = load([{**SENSORS[2], "believed": believed}]).with_changes({"sensors[0].believed.position.noise": 0.1})
    assert changed.sections.sensors[0].nominal.position.noise == 0.1


@pytest.mark.parametrize(
    ("believed", "text"),
    [
        ({"antena": [0, 0, 1]}, r"sensors\[0\].believed.antena: unknown key"),
        ({"antenna": [0, 0]}, r"believed.antenna: expected 3 numbers"),
        ({"position": {"bias": [1, 2]}}, "believed.position.bias: expected one number, or 3"),
        ({"delay": 0.001}, "believed.delay: must be that of the sensor"),
        ({"period": 0.001}, "believed.period: must be that of the sensor"),
        ({"type": "pose"}, "believed.type: must be that of the sensor"),
        ({"dropout": 0.1}, "believed.dropout: has no effect: estimators know which measurements have arrived; remove"),
    ],
)
def test_invalid_believed_values_are_reported(believed, text):
    with pytest.raises(ScenarioError, match=text):
        load([{"type": "receiver", "believed": believed}])
    with pytest.raises(ScenarioError, match="with 3 values, as measured, got 6"):
        load([{**LENS, "believed": {"markers": [[0.0, 0.0, 1.0], [0.0, 0.0, 1.1]]}}])


def test_invalid_believed_values_of_a_sensor_without_scenario_are_errors():
    with pytest.raises(CdprError, match="antenna"):
        _ = cdpr.sensing.Receiver(believed={"antenna": [0.0, 0.0]}).nominal


def test_estimators_get_the_believed_sensors(monkeypatch):
    given = []
    make = estimation._make

    def spy(entry, robot, scenario, sensors):
        given.append([model.sensor.title for model in sensors] + [model.sensor.length.noise for model in sensors])
        return make(entry, robot, scenario, sensors)

    monkeypatch.setattr(estimation, "_make", spy)
    sensor = {"type": "encoders", "name": "drums", "length": {"noise": 1e-3}, "believed": {"length": {"noise": 2e-3}}}
    overrides = {"sensors": [sensor], "estimator": {"type": "forward_kinematics"}}
    with cdpr.Simulation("caroca", overrides=overrides) as simulation:
        simulation.step()
    assert {*map(tuple, given)} == {("drums", 2e-3)}
