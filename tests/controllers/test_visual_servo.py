"""The controller `visual_servo`: its law against numpy, its region of convergence, late, lost and missing images."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import pytest
from conftest import GRAVITY, ROOT, random_state
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.mechanics import dynamics
from cdpr.plugins import ControllerInputs
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop
from cdpr_controllers import VisualServoOptions
from cdpr_controllers.visual_servo import VisualServo

SCENARIO = ROOT / "scenarios" / "visual_servo.yaml"
STEP = 2e-3
MARKERS = np.array([[0.5, 0.25, 0.2], [-0.5, 0.25, 0.2], [-0.5, -0.25, 0.2], [0.5, -0.25, 0.2], [0.1, 0.0, 0.4]])
DIFFERENCE = 1e-6  # step of finite differences, m and rad: round-off and curvature give 1e-9
# Region of convergence that the documentation states, at rest, m and rad.
REACH, TURN = 0.4, 0.6


def camera(on):
    """A camera 4 m from the markers, as a sensor."""
    axes = Rotation.from_euler("x", np.pi) * Rotation.from_rotvec([0.05, 0.02, 0.4])
    if on == "world":
        place, markers = [0.1, -0.1, 6.0], MARKERS
    else:
        place, markers = [0.05, 0.1, -0.3], MARKERS - [0.0, 0.0, 2.0]
    return cdpr.sensing.Markers(
        name="eye",
        on=on,
        position=place,
        attitude=axes.as_quat(scalar_first=True).tolist(),
        focal=[900.0, 850.0],
        center=[310.0, 250.0],
        markers=markers.tolist(),
    )


def projected(sensor, position, attitude):
    """Normalised image coordinates (2 k,) of the markers for a pose of the platform."""
    mount, axes = np.array(sensor.position), Rotation.from_quat(sensor.attitude, scalar_first=True)
    points = np.array(sensor.markers)
    if sensor.on == "world":
        seen = axes.inv().apply(position + attitude.apply(points) - mount)
    else:
        seen = axes.inv().apply(attitude.inv().apply(points - position) - mount)
    return (seen[:, :2] / seen[:, 2:]).ravel()


def displaced(position, attitude, e):
    return position + e[:3], Rotation.from_rotvec(e[3:]) * attitude


def matrix_at(sensor, position, attitude):
    """Interaction matrix (2 k, 6) at a pose by central differences."""
    image = lambda e: projected(sensor, *displaced(position, attitude, e))  # noqa: E731
    columns = [(image(DIFFERENCE * e) - image(-DIFFERENCE * e)) / (2 * DIFFERENCE) for e in np.eye(6)]
    return np.array(columns).T


class Bench:
    """A controller with a camera whose measurements are written by hand."""

    def __init__(self, robot, on="world", **options):
        self.sensor = camera(on)
        k = len(self.sensor.markers)
        self.pixel, self.seen, self.age = np.zeros(2 * k), np.ones(k), np.zeros(1)
        self.servo = VisualServo(robot, GRAVITY, STEP, VisualServoOptions(**options))
        self.columns = {name: np.full(1, np.nan) for name in ("servo_error", "servo_markers", "servo_age")}
        self.servo.log(self.columns)
        self.servo.use_sensors({"eye": self.sensor})
        measured = {"eye_pixel": self.pixel, "eye_seen": self.seen, "eye_age": self.age}
        limits = np.array([robot.tension_min, robot.tension_max])
        inputs = (lambda times: None), limits, np.zeros(robot.m, dtype=bool), np.zeros(robot.m)
        self.servo.observe(ControllerInputs(*inputs, MappingProxyType(measured)))

    def look(self, position, attitude):
        image = projected(self.sensor, position, attitude).reshape(-1, 2)
        self.pixel[:] = (image * [900.0, 850.0] + [310.0, 250.0]).ravel()

    def wrench(self, desired):
        out = np.full(6, np.nan)
        self.servo.control(0.0, np.full(13, np.nan), desired, out)  # the state is not used
        return out


def case(seed):
    """A desired state at rest (19,), its pose, and the displacement (6,) of the platform from it."""
    rng = np.random.default_rng(seed)
    desired = np.zeros(19)
    desired[:7] = random_state(rng)[:7]
    e = np.concatenate([rng.uniform(-0.1, 0.1, 3), rng.uniform(-0.15, 0.15, 3)])
    return desired, (desired[:3], Rotation.from_quat(desired[3:7], scalar_first=True)), e


@pytest.mark.parametrize("on", ["world", "platform"])
@pytest.mark.parametrize("interaction", ["desired", "current", "mean"])
def test_the_wrench_of_the_first_image(offset_robot, on, interaction):
    for seed in range(2):
        desired, goal, e = case(seed)
        bench = Bench(offset_robot, on, kp=(1, 2, 3, 4, 5, 6), kd=7.0, interaction=interaction)
        actual = displaced(*goal, -e)
        bench.look(*actual)
        missing = projected(bench.sensor, *goal) - projected(bench.sensor, *actual)
        found = np.zeros(6)
        for _ in range(5):  # the matrix at the estimated pose has the measured image coordinates
            position, attitude = displaced(*goal, -found)
            here = matrix_at(bench.sensor, position, attitude)
            here += correction(bench.sensor, (position, attitude), projected(bench.sensor, *actual))
            there = matrix_at(bench.sensor, *goal)
            L = {"desired": there, "current": here, "mean": 0.5 * (here + there)}[interaction]
            found = np.linalg.lstsq(L, missing, rcond=None)[0]
        position, attitude = displaced(*goal, -found)
        state = np.concatenate([position, attitude.as_quat(scalar_first=True), np.zeros(6)])
        a = np.arange(1, 7) * found
        expected = dynamics.required_wrench(offset_robot, state, GRAVITY, a[:3], a[3:])
        np.testing.assert_allclose(bench.wrench(desired), expected, atol=1e-4)  # N, of 500 N: finite differences


def correction(sensor, pose, measured):
    """What the measured image coordinates change in the interaction matrix at a pose (2 k, 6): they enter linearly."""
    own = projected(sensor, *pose)
    k, change = len(own) // 2, np.zeros((len(own), 6))
    for i in range(k):
        depth_rate = np.array(
            [(depth(sensor, pose, DIFFERENCE * e)[i] - depth(sensor, pose, -DIFFERENCE * e)[i]) for e in np.eye(6)]
        ) / (2 * DIFFERENCE * depth(sensor, pose, np.zeros(6))[i])
        for j in range(2):
            change[2 * i + j] = -(measured[2 * i + j] - own[2 * i + j]) * depth_rate
    return change


def depth(sensor, pose, e):
    """Distances (k,) of the markers along the optical axis, m, for a displaced pose."""
    position, attitude = displaced(*pose, e)
    axes = Rotation.from_quat(sensor.attitude, scalar_first=True)
    points = np.array(sensor.markers)
    world = sensor.on == "world"
    body = position + attitude.apply(points) if world else attitude.inv().apply(points - position)
    return axes.inv().apply(body - np.array(sensor.position))[:, 2]


def test_without_images_the_feedback_fades_as_predicted(offset_robot):
    """kp = 25 and kd = 10: e = e0 (1 + 5 t) exp(-5 t) from rest."""
    desired, goal, e = case(0)
    bench = Bench(offset_robot, kp=25.0, kd=10.0)
    bench.look(*displaced(*goal, -e))
    bench.wrench(desired)
    bench.seen[:] = 0.0
    for k in range(1, 401):
        bench.age[0] = 0.0  # an image in each step, without markers
        found = bench.wrench(desired)
        if k in (50, 200, 400):
            t = k * STEP
            assert bench.servo.arrays[0][:3] == pytest.approx(e[:3] * (1 + 5 * t) * np.exp(-5 * t), abs=2e-3)
    assert bench.columns["servo_age"][0] == pytest.approx(400 * STEP)
    assert bench.columns["servo_markers"][0] == 0.0
    still = np.concatenate([desired[:7], np.zeros(6)])
    weight = dynamics.required_wrench(offset_robot, still, GRAVITY, np.zeros(3), np.zeros(3))
    np.testing.assert_allclose(found, weight, rtol=0.0, atol=0.05 * np.linalg.norm(weight))


@pytest.mark.parametrize("hidden", [[0], [0, 1]])
def test_any_three_markers_suffice(offset_robot, hidden):
    desired, goal, _ = case(1)
    e = np.array([0.02, -0.01, 0.015, 0.01, -0.02, 0.03])
    bench = Bench(offset_robot)
    bench.look(*displaced(*goal, -e))
    bench.seen[hidden] = 0.0
    bench.pixel.reshape(-1, 2)[hidden] = 1e5
    bench.wrench(desired)
    assert bench.servo.arrays[0] == pytest.approx(e, abs=2e-4)  # third order of the displacement
    assert bench.columns["servo_markers"][0] == 5 - len(hidden)


def starts(count, seed=0):
    """Displacements (6,) from the goal, uniformly distributed in the region of convergence."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        parts = rng.normal(size=(2, 3))
        sizes = np.array([REACH, TURN]) * rng.uniform(size=2) ** (1 / 3)
        yield (sizes[:, None] * parts / np.linalg.norm(parts, axis=1, keepdims=True)).ravel()


@pytest.mark.parametrize(
    "count", [pytest.param(30, id="30 starts"), pytest.param(1000, id="1000 starts", marks=pytest.mark.slow)]
)
def test_it_converges_from_its_region(count):
    goal = np.array([0.0, 0.0, 1.2])
    changes = {"trajectory": {"type": "hold"}, "initial.position": goal.tolist(), "simulation.duration": 4.0}
    scenario = cdpr.load_scenario(SCENARIO, overrides=changes)
    loop = Loop(build(scenario))
    rows = np.empty((scenario.simulation.steps + 1, len(loop.row)))
    state = loop.layout.span("position", "angular_velocity")
    error = loop.layout.span("servo_error", "servo_error")
    for e in starts(count):
        attitude = Rotation.from_rotvec(e[3:]).as_quat(scalar_first=True)
        loop.reset(np.concatenate([goal + e[:3], attitude, np.zeros(6)]))
        loop.run(rows, lambda _: None)
        settled = rows[-250:, state]  # the last half second
        turned = Rotation.from_quat(settled[:, 3:7], scalar_first=True).magnitude()
        # Noise of 0.2 px at 3.6 m and 800 px/rad is 1 mm; five markers, the filter and the loop give 1.5 mm, 5 mrad.
        assert np.linalg.norm(settled[:, :3] - goal, axis=1).max() < 5e-3, e
        assert turned.max() < 15e-3, e
        assert rows[-1, error][0] < 2.0  # px


def tracking_error(**overrides):
    """Largest distance from the desired position, m."""
    exact = {"sensors.0.pixel": {"noise": 0.0}, **overrides}
    run = cdpr.simulate(SCENARIO, overrides=exact)
    return float(np.abs(run.position - run["desired_position"]).max())


def test_late_images_correct_the_estimate_of_their_time():
    """An image taken as one of now would be 12 mm behind: 0.3 m/s at most, and two periods of 20 ms."""
    assert tracking_error(**{"sensors.0.delay": 0.04}) < 2e-4
    assert tracking_error(**{"sensors.0.delay": 0.0, "sensors.0.period": 0.0}) < 2e-4


def test_it_sees_again_after_an_obstacle():
    """A beam hides all markers on the way of a platform that is 2 % heavier than its model."""
    way = {"initial.position": [0.0, -0.7, 1.2], "trajectory.to": {"position": [0.0, 0.7, 1.2]}}
    beam = [{"name": "beam", "box": [3.0, 0.4, 0.05], "position": [0.0, 0.0, 3.0]}]
    heavier = {"believed": {"platform": {"mass": 147.0}}, "world.obstacles": beam}
    run = cdpr.simulate(SCENARIO, overrides={**way, **heavier, "sensors.0.pixel": {"noise": 0.0}})
    hidden = run["servo_markers"] == 0
    assert 0.2 < hidden.sum() * STEP < 1.0
    assert run["servo_age"][hidden].max() > 0.2
    error = np.linalg.norm(run.position - run["desired_position"], axis=1)
    droop = 0.02 * 9.81 / 25.0  # m, of the proportional term
    assert error[hidden].max() < 1.5 * droop  # the load is known by then
    assert error[-250:] == pytest.approx(droop, rel=0.05)
    assert run["servo_markers"][-1] == 5


def test_a_planar_robot_needs_two_markers():
    sensor = {
        "type": "markers",
        "position": [0.0, -6.0, 2.0],
        "attitude": Rotation.from_euler("x", -np.pi / 2).as_quat(scalar_first=True).tolist(),
        "markers": [[0.1, -0.5, 0.05], [-0.1, -0.5, 0.05]],
    }
    overrides = {"sensors": [sensor], "controller": {"type": "visual_servo"}}
    run = cdpr.simulate(ROOT / "scenarios" / "planar.yaml", overrides=overrides)
    assert run["markers_seen"].min() == 1.0
    assert np.abs(run.position - run["desired_position"]).max() < 1e-3


def test_a_snapshot_repeats_its_bits():
    with cdpr.Simulation(cdpr.load_scenario(SCENARIO, overrides={"simulation.duration": 0.5})) as simulation:
        simulation.step(105)  # between two images
        saved = simulation.snapshot()
        simulation.step(100)
        first = simulation.rows().copy()
        simulation.restore(saved)
        simulation.step(100)
        assert np.array_equal(simulation.rows(), first)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"sensors": []}, "visual_servo: needs the image points of markers: add a sensor of the type markers"),
        ({"sensors.0.markers": [[0, 0, 0], [0, 0, 1]]}, "2 markers, which determine at most 4 of 6 degrees of freedom"),
        ({"sensors.0.markers": [[0, 0, 0], [0, 0, 1], [0, 0, 3]]}, "'camera' are on one line: move one"),
        ({"controller.smoothing": 0.0}, "controller.smoothing: must be greater than 0"),
        ({"controller.interaction": "both"}, "controller.interaction: "),
    ],
)
def test_unsuitable_scenarios_are_rejected(change, text):
    with pytest.raises(cdpr.CdprError, match=text):
        build(cdpr.load_scenario(SCENARIO, overrides=change))
