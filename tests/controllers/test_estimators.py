"""Estimators of ours against computations of their equations by scipy and numpy."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from conftest import ROOT
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.mechanics.forward_kinematics import forward_kinematics
from cdpr.ui.report.text.reservations import reservations

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
COGIRO = str(ROOT / "scenarios" / "cogiro_pulleys.yaml")
PLANAR = str(ROOT / "scenarios" / "planar.yaml")
GRAVITY = np.array([0.0, 0.0, -9.81])  # m/s^2
STEP = 0.001  # s
FIT = 1e-9  # m and rad: scipy stops at relative changes of the cost of 1e-15
REPLAY = 1e-10  # m, rad, m/s and rad/s: round-off of hundreds of steps
POINT = [0.1, -0.05, 0.2]  # m
IMU = {"type": "imu", "point": POINT, "force": {"noise": 0.02}, "turn_rate": {"noise": 1e-3, "bias": 5e-3}}


def run(sensors, estimator, scenario=CAROCA, **overrides):
    return cdpr.simulate(
        scenario,
        overrides={"simulation.duration": 0.3, "sensors": sensors, "estimator": estimator, **overrides},
    )


def lengths_at(robot, position, rotation):
    """Return the lengths (m,) of cables between points."""
    anchors = np.array([cable.frame for cable in robot.cables])
    points = np.array([cable.platform for cable in robot.cables])
    return np.linalg.norm(anchors - position - rotation.apply(points), axis=1)


def test_forward_kinematics_is_the_least_squares_fit():
    noise = {"type": "encoders", "length": {"noise": 1e-3}}
    found = run([noise], {"type": "forward_kinematics"})
    robot = cdpr.load_scenario(CAROCA).robot
    for k in (0, 57, 300):
        target = np.asarray(found["encoders_length"][k])
        about = Rotation.from_quat(found.orientation[k], scalar_first=True)
        position = np.asarray(found.position[k])

        def residual(x, target=target, about=about, position=position):
            return lengths_at(robot, position + x[:3], Rotation.from_rotvec(x[3:]) * about) - target

        fit = least_squares(residual, np.zeros(6), xtol=1e-15, ftol=1e-15, gtol=1e-15)
        assert np.abs(found["estimated_position"][k] - position - fit.x[:3]).max() < FIT
        turned = Rotation.from_quat(found["estimated_orientation"][k], scalar_first=True)
        assert (turned * (Rotation.from_rotvec(fit.x[3:]) * about).inv()).magnitude() < FIT
        assert found["fit_residual"][k] == pytest.approx(np.linalg.norm(fit.fun), rel=1e-6)
    assert np.abs(found["estimated_position"] - found.position).max() > 1e-4


@pytest.mark.parametrize("filter_time", [0.0, 0.02])
def test_velocities_are_filtered_differences(filter_time):
    """With encoders of 250 Hz, which are 2 ms late: velocities change when measurements arrive."""
    slow = {"type": "encoders", "length": {"noise": 1e-4}, "period": 0.004, "delay": 0.002}
    found = run([slow], {"type": "forward_kinematics", "filter_time": filter_time})
    arrivals = [0, *range(6, 301, 4)]
    position = np.asarray(found["estimated_position"])
    turned = Rotation.from_quat(found["estimated_orientation"], scalar_first=True)
    velocity, turning = np.zeros(3), np.zeros(3)
    for before, now in itertools.pairwise(arrivals):
        share = 0.004 / (filter_time + 0.004)
        velocity = velocity + share * ((position[now] - position[before]) / 0.004 - velocity)
        turn = (turned[now] * turned[before].inv()).as_rotvec()
        turning = turning + share * (turn / 0.004 - turning)
        for k in range(now, min(now + 4, 301)):  # held until the next one
            assert np.abs(found["estimated_velocity"][k] - velocity).max() < REPLAY
            assert np.abs(found["estimated_angular_velocity"][k] - turning).max() < REPLAY
            assert np.array_equal(position[k], position[now])


@pytest.mark.parametrize("scenario", [COGIRO, PLANAR])
def test_exact_lengths_give_the_exact_pose(scenario):
    """Of a robot with pulleys, and of a planar one, whose other directions remain exact."""
    found = run([{"type": "encoders"}], {"type": "forward_kinematics"}, scenario)
    assert found.status == "finished"
    assert np.abs(found["estimated_position"] - found.position).max() < FIT
    assert np.abs(found["estimated_orientation"] - found.orientation).max() < FIT


NEGATIVE = {"type": "encoders", "length": {"bias": -20.0}}


def test_a_fit_that_fails_holds_the_pose():
    """Negative lengths fit no pose: their least squares have no minimum with a short last step."""
    found = run([NEGATIVE], {"type": "forward_kinematics"})
    assert np.isnan(found["fit_residual"]).all()
    assert (found["estimated_position"] == found.position[0]).all()


@pytest.mark.parametrize("kind", ["forward_kinematics", "complementary"])
def test_a_run_states_at_how_many_samples_no_pose_fits(kind):
    """The log has all rows, or few of them."""
    for more in ({}, {"log.step": 0.1}):
        found = run([NEGATIVE, {"type": "imu"}], {"type": kind}, **more)
        assert found.summary()["estimate"]["unfitted_samples"] == 301
        assert "the measured lengths fit no pose at 301 of 301 samples" in list(reservations(found))
    exact = run([{"type": "encoders"}, {"type": "imu"}], {"type": kind})
    assert exact.summary()["estimate"]["unfitted_samples"] == 0
    assert not any("fit no pose" in each for each in reservations(exact))


def test_a_filter_that_fits_no_poses_has_no_residual():
    found = run([{"type": "pose"}, {"type": "imu"}], {"type": "complementary"})
    assert (found["fit_residual"] == 0.0).all()


def replayed(found, gains, correcting):
    """Return position, rotation, velocity and angular velocity of the complementary filter, by its equations.

    The filter corrects by the poses (K, 3) and rotations `correcting`, at each sample but the first.
    """
    bandwidth, attitude_gain, bias_gain = gains
    positions, attitudes = correcting
    force, turn = np.array(found["imu_force"]), np.array(found["imu_turn_rate"])
    R = Rotation.from_quat(found.orientation[0], scalar_first=True)
    v = np.asarray(found.velocity[0]) + np.cross(found.angular_velocity[0], R.apply(POINT))
    p, bias, before = (
        found.position[0] + R.apply(POINT),
        np.zeros(3),
        R.inv().apply(np.array(found.angular_velocity[0])),
    )
    states = []
    for k in range(len(found.time)):
        if k:
            R = R * Rotation.from_rotvec(STEP * (0.5 * (before + turn[k]) - bias))
            before, last = turn[k], v
            v = v + STEP * (R.apply(force[k]) + GRAVITY)
            p = p + 0.5 * STEP * (last + v)
            apart = positions[k] + attitudes[k].apply(POINT) - p
            p, v = p + 2.0 * bandwidth * STEP * apart, v + bandwidth**2 * STEP * apart
            w, *axis = (R.inv() * attitudes[k]).as_quat(scalar_first=True)
            tilt = 2.0 * w * np.array(axis)  # vex of the antisymmetric part of the error's rotation matrix
            R, bias = R * Rotation.from_rotvec(attitude_gain * STEP * tilt), bias - bias_gain * STEP * tilt
        omega = R.apply(before - bias)
        states.append((p - R.apply(POINT), R, v - np.cross(omega, R.apply(POINT)), omega))
    return states


def assert_replayed(found, states):
    for k in (0, 1, 150, 300):
        position, R, velocity, omega = states[k]
        assert np.abs(found["estimated_position"][k] - position).max() < REPLAY
        turned = Rotation.from_quat(found["estimated_orientation"][k], scalar_first=True)
        assert (turned * R.inv()).magnitude() < REPLAY
        assert np.abs(found["estimated_velocity"][k] - velocity).max() < REPLAY
        assert np.abs(found["estimated_angular_velocity"][k] - omega).max() < REPLAY


def test_complementary_filter_with_a_measured_pose():
    pose = {"type": "pose", "position": {"noise": 1e-3}, "attitude": {"noise": 1e-3}}
    gains = {"bandwidth": 20.0, "attitude_gain": 8.0, "bias_gain": 2.0}
    found = run([IMU, pose], {"type": "complementary", **gains})
    attitudes = Rotation.from_quat(found["pose_attitude"], scalar_first=True)
    assert_replayed(found, replayed(found, gains.values(), (np.asarray(found["pose_position"]), attitudes)))


def test_complementary_filter_with_encoders():
    """The fit is that of the estimator `forward_kinematics` with the same sensors in the same motion."""
    encoders = {"type": "encoders", "length": {"noise": 1e-3}}
    gains = {"bandwidth": 20.0, "attitude_gain": 8.0, "bias_gain": 2.0}
    found = run([IMU, encoders], {"type": "complementary", **gains})
    robot = cdpr.load_scenario(CAROCA).robot
    start = np.concatenate([found.position[0], found.orientation[0]])
    poses = [forward_kinematics(robot, lengths, start).pose for lengths in np.asarray(found["encoders_length"])]
    positions = np.array(poses)[:, :3]
    attitudes = Rotation.from_quat(np.array(poses)[:, 3:], scalar_first=True)
    assert_replayed(found, replayed(found, gains.values(), (positions, attitudes)))


def test_complementary_filter_finds_the_bias_and_smooths():
    """With 0.5 mm noise, its velocities are a hundred times better than differences of the fitted poses."""
    encoders = {"type": "encoders", "length": {"noise": 5e-4}}
    duration = {"simulation.duration": 2.0}
    smooth = run([IMU, encoders], {"type": "complementary"}, **duration).summary()["estimate"]
    rough = run([IMU, encoders], {"type": "forward_kinematics"}, **duration).summary()["estimate"]
    assert smooth["velocity_error_m_s"]["rms"] < 0.01 * rough["velocity_error_m_s"]["rms"]
    assert smooth["position_error_m"]["rms"] < 5e-4


def test_complementary_filter_converges_after_an_occlusion():
    """Without a limit of the time between poses, the first pose after the gap would multiply the error by eleven."""
    bias, bandwidth, begin, gap = 0.1, 10.0, 200, 600  # m/s^2, rad/s, samples
    sensors = [{"type": "imu", "force": {"bias": [bias, 0.0, 0.0]}}, {"type": "pose"}]
    lost = {"type": "sensor_occlusion", "time": begin * STEP, "duration": gap * STEP, "sensor": "pose"}
    more = {"simulation.duration": 1.8, "events": [lost]}
    found = run(sensors, {"type": "complementary", "bandwidth": bandwidth}, **more)
    error = np.linalg.norm(found["estimated_position"] - found.position, axis=1)
    # Error of the critically damped observer at the beginning of the gap, and of its velocity; then both integrate.
    decay, final = np.exp(-bandwidth * begin * STEP), bias / bandwidth**2
    first = final * (1.0 - (1.0 + bandwidth * begin * STEP) * decay)
    velocity = bias * begin * STEP * decay + 2.0 * bandwidth * first
    end, lasts = begin + gap, gap * STEP
    assert error[end] == pytest.approx(first + velocity * lasts + 0.5 * bias * lasts**2, rel=0.02)  # of Euler's steps
    assert (error[end + 1 :] < error[end]).all()
    assert error[-1] == pytest.approx(final, rel=0.05)  # after ten time constants
