"""Failures, occlusions and bumps of sensors in runs, snapshots, rollouts, and from outside."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from restarts import assert_restarts_give
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.base.errors import CdprError

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
STEP, COUNT = 0.001, 50
MOUNT, MOVED, TURNED = np.array([0.1, -0.2, 0.3]), np.array([0.02, 0.0, -0.05]), np.array([0.3, -0.2, 0.1])
NOISY = {"noise": 1e-3, "drift": 1e-3}
SENSORS = [
    {"type": "pose", "name": "mocap", "position": NOISY, "attitude": NOISY, "delay": 0.003, "dropout": 0.1},
    {"type": "twist"},
    {"type": "encoders", "length": {"noise": 1e-4}, "period": 0.002},
    {"type": "receiver", "antenna": MOUNT.tolist()},
    {"type": "imu", "point": MOUNT.tolist()},
    {"type": "range", "point": MOUNT.tolist()},
    {
        "type": "markers",
        "on": "platform",
        "position": MOUNT.tolist(),
        "markers": [[0.5, 0.5, 4.0]],
        "focal": [200, 200],
    },
]
EVENTS = [
    {"type": "sensor_occlusion", "time": 0.010, "duration": 0.005, "sensor": "mocap"},
    {"type": "sensor_bump", "time": 0.020, "sensor": "encoders", "bias": 0.5},
    {"type": "sensor_bump", "time": 0.020, "sensor": "receiver", "position": MOVED.tolist()},
    *(
        {"type": "sensor_bump", "time": 0.020, "sensor": each, "position": MOVED.tolist(), "rotation": TURNED.tolist()}
        for each in ("imu", "range", "markers")
    ),
    {"type": "sensor_failure", "time": 0.030, "sensor": "mocap", "duration": 0.008},
    {"type": "sensor_failure", "time": 0.035, "sensor": "mocap"},
]
FLOOR = {"box": [20.0, 20.0, 1.0], "position": [0.0, 0.0, -2.0]}
ROUND_OFF = 1e-12  # m: of poses of some metres
DIFFERENCES = 1e-9  # m/s^2: of velocities over a millisecond


def run(sensors=SENSORS, events=EVENTS, **more):
    return cdpr.simulate(CAROCA, overrides={"simulation.duration": 0.05, "sensors": sensors, "events": events, **more})


@pytest.fixture(scope="module")
def disturbed():
    return run()


def test_lost_measurements_hold_the_last_value_and_its_age_grows():
    sensor = {"type": "receiver", "delay": 0.003, "position": {"noise": 1e-3}}
    lost = {"type": "sensor_occlusion", "time": 0.010, "duration": 0.005, "sensor": "receiver"}
    plain, other = (run([sensor], events) for events in ([], [lost, {**lost, "type": "sensor_failure", "time": 0.03}]))
    taken = np.array([k <= 10 or 15 < k <= 30 or k > 35 for k in range(COUNT + 1)])
    last = np.maximum.accumulate(np.where(taken, np.arange(COUNT + 1), 0))
    arrived = last[np.maximum(np.arange(COUNT + 1) - 3, 0)]
    assert other["receiver_age"] == pytest.approx(STEP * (np.arange(COUNT + 1) - arrived))
    # The noise of the measurements that are not lost is the same.
    assert np.array_equal(other["receiver_position"], plain["receiver_position"][np.minimum(arrived + 3, COUNT)])


def test_a_failed_sensor_recovers_only_if_no_other_failure_lasts(disturbed):
    age = disturbed["mocap_age"]
    assert age[14:18].max() >= 0.006
    assert np.all(np.diff(age[34:]) > 0.0)
    assert disturbed.position.tobytes() != run(events=[]).position.tobytes()  # the controller sees it


def test_bumps_step_the_bias_and_move_mounts(disturbed):
    step = (disturbed["encoders_length"] - disturbed.length)[::2]
    assert np.abs(step[:11]).max() < 1e-3
    assert np.abs(step[11:] - 0.5).max() < 1e-3
    after = np.arange(COUNT + 1) > 20
    R = Rotation.from_quat(disturbed.orientation, scalar_first=True)
    places = np.where(after[:, None], MOUNT + MOVED, MOUNT)
    assert np.abs(disturbed["receiver_position"] - disturbed.position - R.apply(places)).max() < ROUND_OFF
    start, axes = disturbed.position + R.apply(places), [R[k] * turn(k) for k in range(COUNT + 1)]
    for k in (20, 21, COUNT):
        u, v = disturbed["markers_pixel"][k, :2]
        x, y, z = axes[k].inv().apply(np.array([0.5, 0.5, 4.0]) - start[k])
        assert disturbed["markers_seen"][k] == 1.0
        assert (u, v) == pytest.approx((200.0 * x / z + 320.0, 200.0 * y / z + 240.0), abs=1e-9)


def test_a_bumped_range_sensor_measures_along_its_new_ray():
    sensed = run([SENSORS[5]], [EVENTS[4]], **{"world.obstacles": [FLOOR]})
    after = np.arange(COUNT + 1) > 20
    R = Rotation.from_quat(sensed.orientation, scalar_first=True)
    start = sensed.position + R.apply(np.where(after[:, None], MOUNT + MOVED, MOUNT))
    rays = np.array([(R[k] * turn(k)).apply([0.0, 0.0, -1.0]) for k in range(COUNT + 1)])
    assert np.abs(sensed["range_distance"] - (start[:, 2] + 1.5) / -rays[:, 2]).max() < ROUND_OFF


def test_a_bumped_imu_measures_in_its_new_axes():
    plain, bumped = (run([SENSORS[4]], events) for events in ([], [EVENTS[3]]))
    still = {**EVENTS[3], "position": [0.0, 0.0, 0.0]}
    turned = run([SENSORS[4]], [still])
    for k in (20, 21, 22, COUNT):
        force, rate = (turn(k).inv().apply(plain[name][k].copy()) for name in ("imu_force", "imu_turn_rate"))
        assert np.abs(turned["imu_force"][k] - force).max() < DIFFERENCES
        assert np.abs(bumped["imu_turn_rate"][k] - rate).max() < ROUND_OFF
    assert not np.allclose(bumped["imu_force"][30:], turned["imu_force"][30:], atol=1e-6)  # another point


def turn(k):
    """Rotation of the bumped mounts at sample k."""
    return Rotation.from_rotvec(TURNED if k > 20 else np.zeros(3))


def test_snapshots_and_resets_contain_the_events(disturbed):
    overrides = {"simulation.duration": 0.05, "sensors": SENSORS, "events": EVENTS}
    assert disturbed.interpreted == ()
    assert_restarts_give(disturbed.rows.tobytes(), CAROCA, overrides)


def test_rollouts_have_the_bits_of_single_runs():
    columns = ["position", "mocap_age", "encoders_length", "receiver_position", "imu_force", "markers_pixel"]
    overrides = {"simulation.duration": 0.05, "sensors": SENSORS, "events": EVENTS}
    seeds = list(range(9))
    batch = cdpr.rollout(CAROCA, 9, vary={"simulation.seed": seeds}, overrides=overrides, columns=columns)
    for i in (0, 8):
        single = run(**{"simulation.seed": seeds[i]})
        assert all(batch[name][i].tobytes() == np.ascontiguousarray(single[name]).tobytes() for name in columns)


def test_events_from_outside_equal_those_of_the_scenario(disturbed, tmp_path):
    overrides = {"simulation.duration": 0.05, "sensors": SENSORS}
    with cdpr.Simulation(CAROCA, overrides=overrides) as simulation:
        simulation.step(10)
        simulation.occlude_sensor("mocap", 0.005)
        simulation.step(10)
        simulation.bump_sensor("encoders", bias=0.5)
        simulation.bump_sensor("receiver", MOVED)
        for name in ("imu", "range", "markers"):
            simulation.bump_sensor(name, MOVED, TURNED)
        simulation.step(10)
        simulation.fail_sensor("mocap", duration=0.008)
        simulation.step(5)
        simulation.fail_sensor("mocap")
        with pytest.raises(CdprError, match="fail_sensor: sensor: unknown sensor 'moca'"):
            simulation.fail_sensor("moca")
        with pytest.raises(CdprError, match="bump_sensor: expected at least one of position"):
            simulation.bump_sensor("mocap")
        simulation.step(20)
        simulation.save(tmp_path / "session.yaml")
        assert simulation.run().rows.tobytes() == disturbed.rows.tobytes()
    assert cdpr.simulate(tmp_path / "session.yaml").rows.tobytes() == disturbed.rows.tobytes()


def test_the_log_lists_the_events(disturbed):
    texts = {(event.time, event.kind): (event.text, event.until) for event in disturbed.events}
    assert texts[0.01, "sensor_occlusion"] == ("sensor 'mocap' is occluded", 0.015)
    assert texts[0.035, "sensor_failure"] == ("sensor 'mocap' fails", None)
    bumps = [event.text for event in disturbed.events if event.kind == "sensor_bump"]
    assert bumps[0] == "sensor 'encoders' is bumped: bias +0.5"
    assert "its mount moves by [0.02, 0, -0.05] m; its mount rotates by [0.3, -0.2, 0.1] rad" in bumps[2]
