"""Sensors in the loop: what they log, what the controller sees of it, and where they are supported."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from plants import installed
from restarts import assert_restarts_give
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.native.random_numbers import Stream, normal_numbers

SCENARIOS = ROOT / "scenarios"
CAROCA, NOISY = str(SCENARIOS / "caroca.yaml"), str(SCENARIOS / "noisy_pose.yaml")
SHORT = {"simulation.duration": 0.05}
EXACT = [{"type": "pose"}, {"type": "twist"}, {"type": "encoders"}, {"type": "tension"}, {"type": "imu"}]
NOISE = [
    {"type": "pose", "position": {"noise": 1e-4}, "attitude": {"noise": 1e-4}, "delay": 0.002, "dropout": 0.1},
    {"type": "twist", "velocity": {"noise": 1e-3, "drift": 1e-3}, "period": 0.002, "jitter": 0.003},
    {"type": "encoders", "length": {"noise": 1e-4}},
]
ENGINES = installed("reference", "mujoco", "bullet", "dart")
WRONG_MATRIX = 1e-3  # m: the directions of the cables are those at the seen pose, 10 mm higher
ROUND_OFF = 1e-12  # m: truth plus noise minus truth, at lengths of some metres


def run(sensors, scenario=CAROCA, **overrides):
    return cdpr.simulate(scenario, overrides={**SHORT, "sensors": sensors, **overrides})


@pytest.mark.parametrize("backend", ENGINES)
@pytest.mark.parametrize("name", ["caroca", "winch", "sagging", "hangprinter"])
def test_exact_sensors_change_no_bit(name, backend):
    scenario = str(SCENARIOS / f"{name}.yaml")
    overrides = {**SHORT, "simulation.backend": backend}
    plain = cdpr.simulate(scenario, overrides=overrides)
    # Encoders see unstretched lengths, which a controller may use: here they are logged only.
    sensed = run([each for each in EXACT if each["type"] != "encoders"], scenario, **overrides)
    for column in plain.header.layout.fields:
        assert np.array_equal(sensed[column], plain[column], equal_nan=True), column
    assert sensed["pose_position"].tobytes() == sensed.position.tobytes()
    assert sensed["twist_turn_rate"].tobytes() == sensed.angular_velocity.tobytes()
    assert not sensed["pose_age"].any()


@pytest.mark.parametrize("backend", ENGINES)
def test_all_engines_have_the_same_noise(backend):
    sensed = run([{"type": "pose", "position": {"noise": 1e-3}}, {"type": "twist"}], **{"simulation.backend": backend})
    noise = 1e-3 * normal_numbers(Stream(0, "sensors.pose").state, 3 * 51).reshape(-1, 3)
    assert np.abs(sensed["pose_position"] - sensed.position - noise).max() < ROUND_OFF


def test_the_controller_sees_the_measured_state():
    bias = (0.0, 0.0, 0.01)
    held = {"simulation.duration": 4.0, "trajectory": {"type": "hold"}}
    sensed = run([{"type": "pose", "position": {"bias": bias}}, {"type": "twist"}], **held)
    assert sensed.position[-1] - sensed.desired_position[-1] == pytest.approx([0.0, 0.0, -0.01], abs=WRONG_MATRIX)
    assert "true_wrench" in sensed.header.layout.fields
    second = run([{"type": "pose"}, {"type": "twist"}, {"type": "pose", "name": "other", "position": {"bias": bias}}])
    plain = cdpr.simulate(CAROCA, overrides=SHORT)
    assert second.position.tobytes() == plain.position.tobytes()
    assert np.array_equal(second["other_position"], second.position + bias)


def test_other_seeds_give_other_noise_and_the_same_seed_the_same_bits():
    one, again, other = run(NOISE), run(NOISE), run(NOISE, **{"simulation.seed": 1})
    assert one.rows.tobytes() == again.rows.tobytes()
    assert not np.array_equal(one["pose_position"], other["pose_position"])


def test_snapshots_and_resets_contain_sensors():
    overrides = {**SHORT, "sensors": NOISE}
    whole = cdpr.simulate(CAROCA, overrides=overrides)
    assert whole.interpreted == ()
    assert_restarts_give(whole.rows.tobytes(), CAROCA, overrides)


def test_rollouts_have_the_bits_of_single_runs():
    seeds = list(range(10))
    columns = ["position", "pose_position", "twist_age", "encoders_rate"]
    batch = cdpr.rollout(
        CAROCA, 10, vary={"simulation.seed": seeds}, overrides={**SHORT, "sensors": NOISE}, columns=columns
    )
    for i in (0, 3, 9):
        single = run(NOISE, **{"simulation.seed": seeds[i]})
        assert all(batch[name][i].tobytes() == np.ascontiguousarray(single[name]).tobytes() for name in columns)


def test_an_imu_measures_mean_specific_force_and_turn_rate():
    point, every = np.array([0.1, -0.2, 0.3]), 4
    sensed = run(
        [{"type": "imu", "point": point.tolist(), "period": every * 0.001}],
        **{"simulation.duration": 0.4, "initial.orientation": {"rpy": [0.1, 0.2, 0.3]}},
    )
    R = Rotation.from_quat(sensed.orientation, scalar_first=True)
    velocity = (sensed.velocity + np.cross(sensed.angular_velocity, R.apply(point)))[::every]
    mean = np.diff(velocity, axis=0) / (every * 0.001) + [0.0, 0.0, 9.81]
    force = R[::every][1:].inv().apply(mean)
    assert np.abs(sensed["imu_force"][every::every] - force).max() < 1e-9  # differences of velocities, over 4 ms
    rate = R[::every].inv().apply(np.array(sensed.angular_velocity[::every]))
    assert np.abs(sensed["imu_turn_rate"][::every] - rate).max() < 1e-12
    assert sensed["imu_force"][0] == pytest.approx(R[0].inv().apply([0.0, 0.0, 9.81]))
    assert np.abs(mean[:, 2] - 9.81).max() > 0.01  # it moves


def test_a_receiver_measures_its_antenna():
    antenna = np.array([0.1, 0.2, 0.3])
    sensed = run(
        [{"type": "receiver", "antenna": antenna.tolist()}], **{"initial.orientation": {"rpy": [0.1, 0.2, 0.3]}}
    )
    R = Rotation.from_quat(sensed.orientation, scalar_first=True)
    assert np.abs(sensed["receiver_position"] - sensed.position - R.apply(antenna)).max() < ROUND_OFF


@pytest.mark.parametrize("friction", [0.0, 0.05])
def test_load_cells_at_the_winch_measure_behind_the_pulley(friction):
    scenario, overrides = str(SCENARIOS / "cogiro_pulleys.yaml"), {"robot.cable.exit.friction": friction}
    sensed = run([{"type": "tension", "at": "winch"}], scenario, **overrides)
    true = sensed["winch_tension"] if friction else sensed.tension
    assert np.array_equal(sensed["tension_tension"][1:], true[:-1])
    assert not sensed["tension_tension"][0].any()


@pytest.mark.parametrize("name", ["caroca", "winch", "sagging", "camera_robot", "plotter"])
def test_load_cells_measure_the_tension_of_the_period_before(name):
    sensed = run([{"type": "tension", "tension": {"bias": 2.0}}], str(SCENARIOS / f"{name}.yaml"))
    true = sensed["cable_tension"] if "cable_tension" in sensed.header.layout.fields else sensed.tension
    assert np.array_equal(sensed["tension_tension"][1:], true[:-1] + 2.0)
    assert np.array_equal(sensed["tension_tension"][0], np.full(sensed.tension.shape[1], 2.0))


def test_encoders_of_ideal_cables_measure_their_lengths():
    sensed = run([{"type": "encoders"}])
    assert sensed["encoders_length"].tobytes() == np.ascontiguousarray(sensed.length).tobytes()
    assert sensed["encoders_rate"][2:] == pytest.approx(np.diff(sensed.length, axis=0)[1:] / 0.001)
    assert np.array_equal(sensed["encoders_rate"][:2], sensed.rate[:2])


@pytest.mark.parametrize("winch", ["position", "velocity"])
def test_encoders_of_cables_that_stretch_are_recorded_only(winch):
    """Controllers and the nominal cables use lengths of cables; unwound lengths would lack the stretch twice."""
    robot, wrenches = str(SCENARIOS / "camera_robot.yaml"), {"controller": {"type": "computed_torque"}}
    overrides = {**SHORT, **wrenches, "robot.winch.type": winch}
    plain, sensed = cdpr.simulate(robot, overrides=overrides), run([{"type": "encoders"}], robot, **overrides)
    assert sensed.position.tobytes() == plain.position.tobytes()
    assert sensed.tension.tobytes() == plain.tension.tobytes()
    rates = sensed["encoders_rate"]
    assert np.abs(rates).max() < 1.1 * np.abs(sensed["unstretched_rate"]).max() + 1e-6


@pytest.mark.parametrize("backend", ENGINES)
@pytest.mark.parametrize("name", ["camera_robot", "hangprinter"])
def test_encoders_of_length_winches_measure_unstretched_lengths(name, backend):
    sensed = run([{"type": "encoders"}], str(SCENARIOS / f"{name}.yaml"), **{"simulation.backend": backend})
    assert np.array_equal(sensed["encoders_length"][1:], sensed["unstretched_length"][1:])
    assert np.array_equal(sensed["encoders_length"][0], sensed.length[0])


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
def test_encoders_of_drums_measure_what_they_have_paid_out(backend):
    sensed = run([{"type": "encoders"}], str(SCENARIOS / "winch.yaml"), **{"simulation.backend": backend})
    robot = cdpr.load_scenario(str(SCENARIOS / "winch.yaml")).robot
    radius = np.array([cable.winch.drum_radius for cable in robot.cables])
    paid_out = -radius * np.diff(sensed["drum_angle"][1:], axis=0)
    assert np.diff(sensed["encoders_length"][1:], axis=0) == pytest.approx(paid_out, abs=1e-12)
    assert np.abs(paid_out).max() > 1e-6


@pytest.mark.parametrize(
    ("sensors", "text"),
    [
        ([{"type": "pose"}], r"sensors\[0\]: the controller uses this pose, and needs a twist"),
        ([{"type": "twist"}], r"sensors\[0\]: the controller uses this twist, and needs a pose"),
        ([{"type": "imu"}, {"type": "imu"}], "sensors 1 and 2 are both named 'imu'"),
        ([{"type": "imu", "period": 0.0005}], r"sensors\[0\].period: must be an integer multiple of control_step"),
        ([{"type": "imu", "name": "Hall 1"}], r"sensors\[0\].name: expected a name of at most 12"),
        ([{"type": "receiver", "name": "desired"}], r"sensors\[0\].name: its column 'desired_position' would have"),
        (
            [{"type": "imu", "name": "x"}, {"type": "encoders", "name": "x_turn"}],
            r"sensors\[1\].name: its column 'x_turn_rate' would have the same name as that of sensor 'x'",
        ),
        ([{"type": "tension", "name": "winch"}], r"sensors\[0\].name: its column 'winch_tension' would have"),
        (
            [{"type": "receiver", "position": {"bias": [1, 2]}}],
            r"position.bias: expected one number, or 3 numbers, got 2",
        ),
        ([{"type": "tension", "tension": {"noise": -1}}], r"sensors\[0\].tension.noise: must be at least 0, got -1"),
        ([{"type": "scan", "rays": 4096, "delay": 1.0}], r"sensors\[0\].delay: 4.1e\+06 values would be on their way"),
        ([{"type": "imu", "dropout": 1.0}], r"sensors\[0\].dropout: must be less than 1"),
        ([{"type": "tensoin"}], "did you mean 'tension'"),
    ],
)
def test_invalid_sensors_are_one_clear_error(sensors, text):
    with pytest.raises(cdpr.ScenarioError, match=text):
        run(sensors)


def test_a_column_of_the_controller_leaves_no_such_name_for_a_sensor():
    scenario = cdpr.load_scenario(str(SCENARIOS / "visual_servo.yaml"), overrides={"sensors.0.name": "servo"})
    text = "column 'servo_age' of controller 'visual_servo' and column 'servo_age' of sensor 'servo' would both be"
    with pytest.raises(
        cdpr.CdprError, match=f"sensors: {text} 'servo_age' in a table: choose another name for"
    ) as found:
        cdpr.simulate(scenario)
    assert found.value.exit_code == 2
