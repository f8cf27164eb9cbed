"""The Kalman filter in the loop: control from encoders, wrong starts, late cameras, guided platforms, winches."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from filtered_robots import GRAVITY, STEP, errors
from plants import installed
from restarts import assert_restarts_give

import cdpr
from cdpr.base.errors import CdprError
from cdpr.plugins import EstimatorInputs, SensorModel
from cdpr_controllers.estimators.ekf import Ekf
from cdpr_controllers.estimators.ekf_stretch import drums_are_resolved

SCENARIOS = ROOT / "scenarios"
ENCODERS_ONLY = str(SCENARIOS / "encoders_only.yaml")
ENCODERS = {"type": "encoders", "length": {"noise": 5e-4}}
STATE = ("position", "orientation", "velocity", "angular_velocity")
TRACKED = 1e-4  # m rms
MARKERS = [[0.5, 0.2, 0.2], [-0.5, 0.2, 0.2], [-0.5, -0.2, 0.2], [0.5, -0.2, 0.2]]  # on the top of CAROCA
CAMERA = {"type": "markers", "position": [0, 0, 5.0], "attitude": [0, 1, 0, 0], "markers": MARKERS}


def states(run, prefix=""):
    return np.hstack([run[f"{prefix}{name}"] for name in STATE])


def error_of(run):
    return errors(states(run), states(run, "estimated_"))


def rms(values):
    return np.sqrt(np.mean(np.sum(values**2, axis=1)))


@pytest.fixture(scope="module")
def tracked():
    return cdpr.simulate(ENCODERS_ONLY)


def test_control_from_encoders_tracks_the_motion(tracked):
    assert tracked.interpreted == ()
    late = tracked.time > 0.5
    assert rms((tracked.position - tracked.desired_position)[late]) < TRACKED
    assert rms(error_of(tracked)[late, :3]) < TRACKED
    share = np.nansum(tracked["nis"]) / tracked["nis_size"].sum()
    assert share == pytest.approx(1.0, abs=0.03)  # 40000 values: 0.007 is one standard deviation


@pytest.mark.parametrize(
    ("place", "turn"), [([0.1, 0.0, 1.2], [0.0, 0.2, 0.0]), ([0.06, -0.05, 1.26], [0.12, -0.1, 0.12])]
)
def test_a_start_a_tenth_of_a_metre_off_is_corrected(place, turn):
    start = {"position": place, "orientation": {"rpy": turn}}
    found = cdpr.simulate(ENCODERS_ONLY, overrides={"estimator.start": start, "simulation.duration": 0.6})
    error = error_of(found)[-100:]
    assert rms(error[:, :3]) < 2 * TRACKED  # noise of 0.5 mm, a wrong start of 100 mm
    assert rms(error[:, 3:6]) < 1e-3


def test_restarts_repeat_the_filter():
    scenario = cdpr.load_scenario(ENCODERS_ONLY).with_changes(
        {"simulation.duration": 0.05, "sensors": [{**ENCODERS, "delay": 0.003, "period": 0.002}]}
    )
    assert_restarts_give(cdpr.simulate(scenario).rows.tobytes(), scenario, {})


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
def test_the_estimate_depends_on_measurements_and_commands_alone(backend):
    """A filter outside of the loop has the same bits from what the log contains."""
    pose = {"type": "pose", "delay": 0.004, "jitter": 0.002, "period": 0.003, "position": {"noise": 1e-3}}
    changes = {"simulation.backend": backend, "simulation.duration": 0.2, "sensors": [ENCODERS, pose]}
    scenario = cdpr.load_scenario(ENCODERS_ONLY).with_changes(changes)
    run = cdpr.simulate(scenario)
    m, models, recorded = scenario.robot.m, [], []
    for sensor in scenario.sections.sensors:
        names = [f"{sensor.title}_{each.key}" for each in sensor.quantities]
        recorded.append((np.hstack([run[name] for name in names]), np.ravel(run[f"{sensor.title}_age"])))
        models.append(SensorModel(sensor, np.zeros(recorded[-1][0].shape[1]), np.zeros(1), np.zeros(1)))
    estimator = Ekf(scenario.robot, GRAVITY, STEP, models, scenario.estimator_options)
    start = states(run)[0]
    start[:7] = [0.05, 0.0, 1.2, *cdpr.model.rotations.from_rpy(0.0, 0.1, 0.0)]
    sent, out, taken = np.zeros(m), np.zeros(13), [-1, -1]
    none = np.zeros((2, m)), np.zeros(m, dtype=bool)
    estimator.connect(EstimatorInputs(np.zeros(1), start, sent, ("tension",) * m, sent, *none))
    for k, time in enumerate(run.time):
        for i, (model, (values, age)) in enumerate(zip(models, recorded, strict=True)):
            when = round(k - age[k] / STEP)
            model.fresh[0], model.age[0], taken[i] = float(when != taken[i]), age[k], when
            model.measured[:] = values[k]
        sent[:] = run.tension[k - 1] if k else 0.0
        estimator.estimate(time, out)
        assert out.tobytes() == states(run, "estimated_")[k].tobytes(), k


def test_late_cameras_and_gyroscopes_determine_the_state():
    """Control from images of 50 Hz that arrive 20 ms later, and a gyroscope."""
    camera = {**CAMERA, "period": 0.02, "delay": 0.02, "pixel": {"noise": 0.2}}
    sensors = [camera, {"type": "imu", "turn_rate": {"noise": 1e-3}}]
    found = cdpr.simulate(ENCODERS_ONLY, overrides={"sensors": sensors, "simulation.duration": 2.5})
    late = found.time > 1.0
    assert found["nis_size"].max() >= 8.0
    error = error_of(found)[late]
    sigma = found["estimate_sigma"][late]
    assert np.mean(np.abs(error) < 3.0 * sigma) > 0.97
    assert rms(error[:, :3]) < 2e-3  # 0.2 px at a distance of 4 m with a focal length of 800 px are 1 mm


def test_a_receiver_and_a_second_pose_are_used():
    sensors = [
        {"type": "receiver", "antenna": [0.3, 0.2, 0.2], "position": {"noise": 1e-3}},
        {"type": "pose", "position": {"noise": 2e-3}, "attitude": {"noise": 2e-3}},
        {"type": "twist", "velocity": {"noise": 1e-2}, "turn_rate": {"noise": 1e-2}},
    ]
    found = cdpr.simulate(ENCODERS_ONLY, overrides={"sensors": sensors, "simulation.duration": 1.0})
    assert np.all(found["nis_size"] == 3 + 6 + 6)
    assert np.nansum(found["nis"]) / found["nis_size"].sum() == pytest.approx(1.0, abs=0.05)
    assert rms(error_of(found)[500:, :3]) < 2e-4


@pytest.mark.parametrize("name", ["planar", "point_mass", "carriage", "spherical"])
def test_guided_platforms_have_no_error_in_blocked_directions(name):
    about = {"sensors": [ENCODERS], "estimator": {"type": "ekf"}, "simulation.duration": 0.8}
    scenario = cdpr.load_scenario(str(SCENARIOS / f"{name}.yaml")).with_changes(about)
    found = cdpr.simulate(scenario)
    blocked = np.setdiff1d(np.arange(6), scenario.robot.rows)
    both = np.concatenate([blocked, blocked + 6])
    assert not found["estimate_sigma"][:, both].any()
    assert np.abs(error_of(found)[:, both]).max() < 1e-12
    assert found["nees"].mean() < 4 * scenario.robot.n  # twice as many as the 2 n of a consistent filter
    assert np.nansum(found["nis"]) / found["nis_size"].sum() == pytest.approx(1.0, abs=0.1)


def test_load_cells_force_robots_whose_winches_take_lengths():
    """Without them, the filter assumes that the platform keeps its velocity."""
    pose = {"type": "pose", "position": {"noise": 1e-3}}
    cells = {"type": "tension", "tension": {"noise": 1.0}}
    found = {}
    for name, sensors in {"with": [pose, cells], "without": [pose]}.items():
        about = {"sensors": sensors, "estimator": {"type": "ekf"}, "simulation.duration": 2.0}
        found[name] = cdpr.simulate(str(SCENARIOS / "camera_robot.yaml"), overrides=about)
        assert found[name].status == "finished"
        assert rms(error_of(found[name])[300:, :3]) < 2e-3
        assert found[name]["nees"][300:].mean() < 8.0  # 6 of a consistent filter
    assert rms(error_of(found["with"])[300:, 6:9]) < 0.2 * rms(error_of(found["without"])[300:, 6:9])


def test_drums_with_inertia_and_friction_are_in_the_model():
    about = {"sensors": [ENCODERS], "estimator": {"type": "ekf"}, "simulation.duration": 1.0}
    found = cdpr.simulate(str(SCENARIOS / "winch.yaml"), overrides=about)
    assert found["nees"].mean() < 12.0  # of a consistent filter; 66 with drums that follow at once
    assert np.nansum(found["nis"]) / found["nis_size"].sum() == pytest.approx(1.0, abs=0.05)  # 8000 values: 0.016
    assert rms(error_of(found)[:, :3]) < 2.5e-4


def test_drums_on_stiff_cables_follow_at_once():
    robot = cdpr.load_robot(SCENARIOS / "robots" / "caroca_winches.yaml")
    assert drums_are_resolved(robot, STEP)
    stiffness = robot.cables[0].axial_stiffness / 4.2  # N/m, of cables of about 4.2 m
    near = 1.0 / np.sqrt(8.0 / 3.0 * stiffness / 150.0)  # s, if they point in all directions alike
    assert not drums_are_resolved(robot, 2.0 * near)
    assert not drums_are_resolved(cdpr.load_robot(SCENARIOS / "robots" / "caroca.yaml"), STEP)
    about = {"sensors": [ENCODERS], "estimator": {"type": "ekf"}, "simulation.duration": 0.4}
    stiff = {"robot.cable.axial_stiffness": 1e8, "robot.cable.damping": 1e4, "simulation.physics_step": 2e-5}
    found = cdpr.simulate(str(SCENARIOS / "winch.yaml"), overrides={**about, **stiff})
    assert found["nees"].mean() < 12.0


@pytest.mark.parametrize("damping", [0.0, 20.0])
def test_load_cells_give_the_stretch_of_soft_lines(damping):
    """The platform drops by a decimetre: the damping of the lines carries up to 10 N, 15 mm of stretch."""
    cells = {"type": "tension", "tension": {"noise": 1.0}}
    about = {"sensors": [ENCODERS, cells], "estimator": {"type": "ekf"}, "simulation.duration": 1.0}
    found = cdpr.simulate(str(SCENARIOS / "camera_robot.yaml"), overrides={**about, "robot.cable.damping": damping})
    assert np.abs(error_of(found)[:, :3]).max() < 3e-3
    assert found["nees"].mean() < 9.0  # 6 of a consistent filter


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("camera_robot", "encoders do not measure the stretch of cable_1, .*add `- type: tension` to sensors"),
        ("sagging", "sag, but the filter has a model of straight cables only; set `believed`"),
    ],
)
def test_cables_that_the_filter_does_not_know_are_rejected(name, text):
    with pytest.raises(CdprError, match=text):
        cdpr.simulate(str(SCENARIOS / f"{name}.yaml"), overrides={"sensors": [ENCODERS], "estimator": {"type": "ekf"}})


def test_exact_sensors_give_the_true_state():
    exact = {"sensors": [{"type": "encoders"}], "estimator": {"type": "ekf"}, "simulation.duration": 0.3}
    found = cdpr.simulate(str(SCENARIOS / "off_centre_mass.yaml"), overrides=exact)
    assert np.abs(error_of(found)[:, :6]).max() < 2e-5  # floor of 1e-6 m, over levers of 0.3 m
    assert found.status == "finished"


def test_sensors_that_determine_nothing_are_rejected():
    with pytest.raises(CdprError, match="expected at least one of pose"):
        cdpr.simulate(ENCODERS_ONLY, overrides={"sensors": [{"type": "range", "direction": [0, 0, -1]}]})


def test_errors_of_estimators_have_their_place_and_name_cameras():
    with pytest.raises(
        CdprError, match=r"encoders_only\.yaml:\d+:\d+: ekf: sensor 'encoders': expected delay and jitter"
    ):
        cdpr.simulate(ENCODERS_ONLY, overrides={"sensors.0.delay": 1.001})
    camera = {"type": "camera", "position": [0, 0, 3.2], "attitude": [0, 1, 0, 0]}
    with pytest.raises(CdprError, match=r"got none; .*; the images of 'camera' \(camera\) are no measurements"):
        cdpr.simulate(ENCODERS_ONLY, overrides={"sensors": [camera]})


def test_a_filter_that_diverges_ends_the_run_as_diverged():
    sensors = [ENCODERS, {"type": "imu", "turn_rate": {"gain": 1e12}}]
    with pytest.raises(cdpr.Diverged, match=r"sees is not finite; .*'estimation': check their options"):
        cdpr.simulate(ENCODERS_ONLY, overrides={"sensors": sensors, "simulation.duration": 0.05})
