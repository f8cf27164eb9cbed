"""Prediction, measurements and late measurements of the Kalman filter against plain numpy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT
from filtered_robots import GRAVITY, STEP, Truth, errors, rotations, turned
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.base.errors import CdprError
from cdpr.plugins import EstimatorInputs, SensorModel
from cdpr.sensing import Encoders, Imu, Markers, Pose, Range, Receiver, Tension, Twist
from cdpr_controllers.estimators import EkfOptions
from cdpr_controllers.estimators.ekf import Ekf

# Terms of second order in the step, h^2 times stiffness per mass, about 100 1/s^2, and the derivative of the inertia by
# the attitude, which is not in the filter: h times the remaining angular acceleration, that of the gyroscopic moment.
OF_SECOND_ORDER = 6e-4
ERRORS = ("position_error", "rotation_error", "velocity_error", "turn_rate_error")
DIFFERENCE = 1e-6  # of the error state, for derivatives by central differences
POSE = np.array([0.1, -0.05, 1.3, *turned(Rotation.from_rotvec([0.1, -0.2, 0.3]))])
STATE = np.array([*POSE, 0.4, -0.3, 0.2, 0.5, -0.6, 0.7])


def load(name):
    return cdpr.load_robot(ROOT / "scenarios" / "robots" / f"{name}.yaml")


class Driven:
    """Filter with the live inputs of given sensors."""

    def __init__(self, robot, *sensors, start=STATE, gravity=GRAVITY, **options):
        widths = [sum(each.values(robot.m) for each in sensor.quantities) for sensor in sensors]
        self.models = [
            SensorModel(sensor, np.zeros(n), np.zeros(1), np.zeros(1))
            for sensor, n in zip(sensors, widths, strict=True)
        ]
        self.estimator = Ekf(robot, gravity, STEP, self.models, EkfOptions(**options))
        self.sent, self.start, self.out, self.step = np.zeros(robot.m), np.array(start), np.zeros(13), -1
        none = np.zeros((2, robot.m)), np.zeros(robot.m, dtype=bool)
        quantities = ("tension",) * robot.m
        self.estimator.connect(EstimatorInputs(np.zeros(1), self.start, self.sent, quantities, self.sent, *none))

    def __call__(self, measured=None, sent=None, late=None):
        """Filter the next step with new measurements of some sensors, by index; return estimate and covariance."""
        self.step += 1
        for i, model in enumerate(self.models):
            model.fresh[0] = float(measured is not None and i in measured)
            model.age[0] = STEP * (late or {}).get(i, 0)
            if model.fresh[0]:
                model.measured[:] = measured[i]
        if sent is not None:
            self.sent[:] = sent
        self.estimator.estimate(self.step * STEP, self.out)
        return self.out.copy(), self.estimator.covariance.copy()


def moved(state, error):
    """State (13,) with an error (12,) added."""
    turn = rotations(state[None, 3:7]) * Rotation.from_rotvec(error[None, 3:6])
    return np.concatenate([state[:3] + error[:3], turned(turn)[0], state[7:] + error[6:]])


def truth_at(robot, states):
    states = np.atleast_2d(states)
    return Truth(robot, (states[:, :3], rotations(states[:, 3:7]), states[:, 7:10], states[:, 10:]))


def advanced(robot, states, tension):
    """States (N, 13) after a control step."""
    truth = truth_at(robot, states)
    truth.advance(np.tile(tension, (len(truth.place), 1)), np.zeros((len(truth.place), 6)))
    return truth.state()


GUIDED = {
    "planar": np.array([0.2, 0.0, 1.4, *turned(Rotation.from_rotvec([0.0, 0.2, 0.0])), 0.3, 0.0, -0.4, 0.0, 0.6, 0.0])
}


@pytest.mark.parametrize("name", ["off_centre", "cogiro_pulleys", "planar"])
def test_the_prediction_is_that_of_an_independent_integrator(name):
    robot, state = load(name), GUIDED.get(name, STATE)
    tension = np.linspace(300.0, 900.0, robot.m) if robot.n == 6 else np.linspace(50.0, 200.0, robot.m)
    filtered = Driven(robot, Pose(), start=state)
    filtered()
    found, _ = filtered(sent=tension)
    error = errors(advanced(robot, state, tension), found[None])[0]
    # The midpoint rule: h^3 / 24 of the third rates of the velocities, some 1e4 m/s^4, and of their integrals.
    assert error[:6] == pytest.approx(0.0, abs=1e-7)
    assert error[6:] == pytest.approx(0.0, abs=3e-6)


def balanced(robot, state, tension):
    """Tensions (m,) near a mean, N, at which the platform hardly accelerates."""
    truth = truth_at(robot, state)
    W = truth.cables(truth.place, truth.turn, truth.velocity, truth.spin)[1][0]
    weight = truth.mass * GRAVITY
    wrench = -np.concatenate([weight, np.cross(truth.turn.apply(np.array(truth.c))[0], weight)])
    rows = robot.rows
    return tension + np.linalg.pinv(W[rows]) @ (wrench - tension * W.sum(axis=1))[rows]


@pytest.mark.parametrize(("name", "tension"), [("off_centre", 900.0), ("cogiro_pulleys", 900.0), ("planar", 150.0)])
def test_the_predicted_covariance_is_that_of_finite_differences(name, tension):
    robot, state = load(name), GUIDED.get(name, STATE)
    tensions = balanced(robot, state, tension)
    free = np.zeros(6)
    free[robot.rows] = 1.0
    filtered = Driven(robot, Pose(), start=state, force_noise=0.0, moment_noise=0.0)
    filtered()
    _, P = filtered(sent=tensions)
    deviations = np.full(12, 0.01) * np.tile(free, 2)
    F = np.zeros((12, 12))
    for j in np.flatnonzero(deviations):
        high, low = advanced(robot, [moved(state, s * DIFFERENCE * np.eye(12)[j]) for s in (1.0, -1.0)], tensions)
        F[:, j] = errors(high[None], low[None])[0] / (2.0 * DIFFERENCE)
    expected = F @ F.T * np.outer(deviations > 0.0, deviations > 0.0)
    assert np.abs(expected - np.diag(np.diag(expected))).max() > 10.0 * OF_SECOND_ORDER  # by stiffness
    assert pytest.approx(expected, abs=OF_SECOND_ORDER) == P / 0.01**2
    assert not P[np.tile(free, 2) == 0.0].any()


def test_unknown_wrenches_spread_the_estimate():
    """Their covariance is that of a wrench which is constant over the step."""
    robot = load("off_centre")
    filtered = Driven(robot, Pose(), start=STATE, force_noise=2.0, moment_noise=0.7, **dict.fromkeys(ERRORS, 0.0))
    filtered()
    _, P = filtered(sent=balanced(robot, STATE, 900.0))
    truth = truth_at(robot, STATE)
    R = np.kron(np.eye(2), truth.turn.as_matrix()[0])
    S = np.linalg.inv(R @ truth.M @ R.T) @ np.diag([4.0] * 3 + [0.49] * 3) @ np.linalg.inv(R @ truth.M @ R.T).T
    assert P[6:, 6:] == pytest.approx(STEP * S, rel=2e-3, abs=1e-9)  # the platform turns by half a mrad on the way
    turned_back = np.kron(np.eye(2), np.eye(3))
    turned_back[3:, 3:] = truth.turn.as_matrix()[0].T
    assert P[:6, 6:] == pytest.approx(0.5 * STEP**2 * turned_back @ S, rel=2e-3, abs=1e-12)
    assert P[:6, :6] == pytest.approx(0.25 * STEP**3 * turned_back @ S @ turned_back.T, rel=2e-3, abs=1e-15)


@pytest.mark.parametrize("every", [1, 10])
def test_held_tensions_spread_the_velocity_with_their_holding_time(every):
    """A constant error over n steps has n^2 times the variance of one step, n independent ones n times."""
    robot, noise, force = load("camera_robot"), 2.0, 30.0
    start = np.array([0.2, 0.1, 1.0, 1.0, *np.zeros(9)])
    known = dict.fromkeys([*ERRORS, "force_noise", "moment_noise"], 0.0)
    last, found = 2 * every - 1 if every > 1 else 10, []
    for each in (noise, 0.0):
        cells = Tension(period=every * STEP, tension={"noise": each})
        filtered = Driven(robot, Pose(), cells, start=start, gravity=np.zeros(3), **known)  # without weight, no change
        for k in range(last + 1):
            _, P = filtered({1: np.full(4, force)} if k > 0 and k % every == 0 else None)
        found.append(P[6:9, 6:9])
    away = robot.anchors[:, :3] - start[:3]
    u = away / np.linalg.norm(away, axis=1)[:, None]
    one = (noise * STEP / robot.platform.mass) ** 2 * u.T @ u
    # Each period has the mean of the tensions at its begin and at its end; the present one has that at its begin.
    weights = [0.5, *np.ones(last - 2), 1.5] if every == 1 else [every]
    expected = one * np.sum(np.square(weights))
    assert pytest.approx(expected, rel=0.01, abs=1e-3 * one.max()) == found[0] - found[1]


def measured_values(sensor, state):
    """Values of a sensor at a state (13,), by plain numpy."""
    R, p = rotations(state[None, 3:7])[0], state[:3]
    if isinstance(sensor, Receiver):
        return p + R.apply(sensor.antenna)
    if isinstance(sensor, Imu):
        return np.concatenate([np.zeros(3), R.inv().apply(state[10:])])
    if isinstance(sensor, Pose):
        return state[:7]
    if isinstance(sensor, Twist):
        return state[7:]
    points, place = np.array(sensor.markers), np.array(sensor.position)
    camera = Rotation.from_quat(sensor.attitude, scalar_first=True)
    points = R.inv().apply(points - p) if sensor.on == "platform" else R.apply(points) + p
    x = camera.inv().apply(points - place)
    pixels = x[:, :2] / x[:, 2:] * sensor.focal + np.array(sensor.size) / 2.0
    return np.concatenate([pixels.ravel(), np.ones(len(points))])


DOWN = (0.0, 1.0, 0.0, 0.0)
MEASURED = [
    Pose(position={"noise": 1e-3}, attitude={"noise": 1e-3}),
    Twist(velocity={"noise": 1e-3}, turn_rate={"noise": 1e-3}),
    Receiver(antenna=[0.2, -0.1, 0.3], position={"noise": 1e-3}),
    Imu(turn_rate={"noise": 1e-3}),
    Markers(position=[0, 0, 4], attitude=DOWN, markers=[[0.3, 0.2, 0.2], [-0.3, 0.1, 0.1]], pixel={"noise": 0.5}),
    Markers(
        on="platform",
        position=[0, 0, -0.1],
        attitude=DOWN,
        markers=[[0.3, 0.2, 0.0], [0, 0.1, 0.1]],
        pixel={"noise": 0.5},
    ),
]


def update(P, H, innovation, noise):
    """Kalman update in the usual form with a matrix inverse: correction, covariance, NIS."""
    S = H @ P @ H.T + np.diag(noise**2)
    K = P @ H.T @ np.linalg.inv(S)
    return K @ innovation, (np.eye(len(P)) - K @ H) @ P, innovation @ np.linalg.solve(S, innovation)


def derivative(values, state):
    ends = [[moved(state, s * DIFFERENCE * e) for s in (1.0, -1.0)] for e in np.eye(12)]
    return np.array([(values(high) - values(low)) / (2.0 * DIFFERENCE) for high, low in ends]).T


@pytest.mark.parametrize("sensor", MEASURED, ids=lambda each: f"{each.type}_{getattr(each, 'on', '')}")
def test_a_measurement_changes_the_estimate_as_the_usual_equations_do(sensor):
    robot, error = load("off_centre"), np.array([3, -2, 1, 2, 1, -3, 10, -5, 5, 4, -6, 2]) * 1e-4
    true = moved(STATE, error)
    filtered = Driven(robot, sensor)
    found, P = filtered({0: measured_values(sensor, true)})
    used = {"pose": slice(0, 6), "imu": slice(3, 6), "markers": slice(0, 4)}.get(sensor.type, slice(None))
    noise = np.full(6, 0.5 if sensor.type == "markers" else 1e-3)[
        : used.stop or {"twist": 6, "receiver": 3}[sensor.type]
    ]
    noise = noise[used] if sensor.type == "imu" else noise
    if sensor.type == "pose":
        H, innovation = np.eye(12)[:6], error[:6]
    else:
        values = measured_values(sensor, true)[used]
        H = derivative(lambda state: measured_values(sensor, state)[used], STATE)
        innovation = values - measured_values(sensor, STATE)[used]
    correction, covariance, nis = update(1e-4 * np.eye(12), H, innovation, noise)
    assert errors(found[None], STATE[None])[0] == pytest.approx(correction, abs=1e-9)
    assert pytest.approx(covariance, abs=1e-10) == P  # of 1e-4; central differences have 1e-9 of that times 1e3 px
    assert np.array_equal(P, P.T)
    assert filtered.estimator.nis[0] == pytest.approx(nis, rel=1e-5)
    assert filtered.estimator.nis_size[0] == len(innovation)


@pytest.mark.parametrize("name", ["off_centre", "cogiro_pulleys", "caroca_winches"])
def test_encoders_change_the_estimate_as_the_usual_equations_do(name):
    robot, tension, stretch = load(name), np.linspace(300.0, 900.0, 8), 1.0
    if robot.cable_model == "elastic":  # the drums turn during the step
        truth = truth_at(robot, STATE)
        truth.start(tension[None])
        truth.advance(tension[None], np.zeros((1, 6)))
        stretch = (truth.cables(truth.place, truth.turn, truth.velocity, truth.spin)[0] / truth.unwound)[0]

    def values(state):
        truth = truth_at(replace(robot, cable_model="ideal"), state)
        return truth.cables(truth.place, truth.turn, truth.velocity, truth.spin)[0][0] / stretch

    sensor = Encoders(length={"noise": 3e-4, "resolution": 1e-3})
    without, filtered = Driven(robot, sensor), Driven(robot, sensor)
    for each in (without, filtered):
        each()
    before, P = without(sent=tension)
    true = moved(before, np.array([3, -2, 1, 2, 1, -3, 0, 0, 0, 0, 0, 0]) * 1e-4)
    found, covariance = filtered({0: [*values(true), *np.zeros(8)]}, sent=tension)
    noise = np.full(8, np.hypot(3e-4, 1e-3 / np.sqrt(12.0)))
    expected, left, nis = update(P, derivative(values, before), values(true) - values(before), noise)
    # Platform and drums advance one after the other: their lengths differ from those of the integrator by 0.1 um.
    near = 2e-7 if robot.cable_model == "elastic" else 1e-8
    assert errors(found[None], before[None])[0] == pytest.approx(expected, abs=near)
    assert covariance == pytest.approx(left, abs=1e-10)
    assert filtered.estimator.nis[0] == pytest.approx(nis, rel=2e-3 if near > 1e-8 else 1e-4)


def test_late_measurements_give_the_estimate_of_measurements_in_time():
    """Two sensors, one of which arrives three steps late, in the order in which they were taken."""
    robot, random = load("off_centre"), np.random.default_rng(0)
    late = Pose(delay=0.003, position={"noise": 1e-3}, attitude={"noise": 1e-3})
    other = Encoders(length={"noise": 5e-4})
    punctual, delayed = Driven(robot, replace_delay(late), other), Driven(robot, late, other)
    poses, lengths, sent = [], [], []
    for k in range(12):
        poses.append(np.concatenate([STATE[:3] + 1e-3 * random.normal(size=3), STATE[3:7]]))
        lengths.append(np.concatenate([cdpr.mechanics.kinematics.lengths(robot, STATE), np.zeros(8)]))
        sent.append(500.0 + 50.0 * random.normal(size=8))
        now = {1: lengths[k]}
        if k >= 3:
            now[0] = poses[k - 3]
        estimate, covariance = delayed(now, sent[k], {0: 3})
    for k in range(12):
        now = {1: lengths[k]}
        if k <= 8:
            now[0] = poses[k]
        expected, P = punctual(now, sent[k])
    assert np.array_equal(estimate, expected)
    assert np.array_equal(covariance, P)


def replace_delay(sensor):
    return sensor.model_copy(update={"delay": 0.0})


def test_exact_sensors_keep_the_covariance_positive():
    robot = load("off_centre")
    filtered = Driven(robot, Pose(), position_error=1.0, rotation_error=1.0, noise_floor=1e-9)
    for _ in range(200):
        _, P = filtered({0: STATE[:7]})
        scale = 1.0 / np.sqrt(np.diag(P))
        assert np.linalg.eigvalsh(P * scale * scale[:, None]).min() > -1e-12


def test_unused_sensors_are_recorded_with_the_reason():
    filtered = Driven(load("off_centre"), Encoders(), Range(direction=[0, 0, -1]))
    assert filtered.estimator.describe()["used"] == ["encoders"]
    assert "map of the hall" in filtered.estimator.describe()["ignored"]["range"]


def test_a_filter_needs_a_sensor_of_the_state_and_short_delays():
    with pytest.raises(CdprError, match=r"expected at least one of pose, .*, got range; add one"):
        Driven(load("off_centre"), Range(direction=[0, 0, -1]))
    with pytest.raises(CdprError, match="at most 1000 control steps, got 2000"):
        Driven(load("off_centre"), Encoders(delay=2.0))
