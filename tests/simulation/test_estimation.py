"""Estimators in the loop: who uses the estimate, what is logged, and what an estimator knows."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from plants import installed
from restarts import assert_restarts_give
from scipy import stats
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.base.errors import CdprError, Diverged, PluginError, ScenarioError
from cdpr.plugins import Estimator, SnapshotOfArrays
from cdpr.plugins.registry import registry

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
SHORT = {"simulation.duration": 0.05}
ENCODERS = [{"type": "encoders", "length": {"noise": 1e-4}}, {"type": "imu", "point": [0.1, 0.0, 0.2]}]
ESTIMATORS = ["forward_kinematics", "complementary", "ekf"]
STATE = "position", "orientation", "velocity", "angular_velocity"
SPREAD = np.array([1e-3, 2e-3, 3e-3, 1e-2, 2e-2, 3e-2, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6])  # standard deviations
ROUND_OFF = 1e-9  # relative, of a quotient of squares


def loaded(estimator: str | type, sensors=ENCODERS, scenario=CAROCA, plugins=None, **overrides):
    plugins = registry()
    if isinstance(estimator, type):
        plugins, estimator = plugins.with_class("estimator", estimator)
    changes = {**SHORT, "sensors": sensors, "estimator": {"type": estimator}, **overrides}
    return cdpr.load_scenario(scenario).with_changes(changes, plugins=plugins)


def run(*arguments, **overrides):
    return cdpr.simulate(loaded(*arguments, **overrides))


def seen_states(scenario):
    """Return the states that a controller sees."""
    states = []

    class Watching(cdpr.plugins.Controller):
        def control(self, time, state, desired, out):
            states.append(state.copy())
            out[:] = 0.0
            out[:3] = -self.robot.platform.mass * self.gravity

    found = cdpr.simulate(scenario, controller=Watching)
    return np.array(states)[-len(found.time) :], found


class Still(SnapshotOfArrays, Estimator):
    """It remains at the start, with a known covariance, and counts the calls."""

    properties = {"covariance": True, "innovation": True, "sensors": ()}  # noqa: RUF012
    closed = 0

    def __init__(self, robot, gravity, control_step, sensors, options):
        super().__init__(robot, gravity, control_step, sensors, options)
        self.covariance = np.diag(SPREAD**2)
        self.covariance[0, 6] = self.covariance[6, 0] = 0.5 * SPREAD[0] * SPREAD[6]
        self.nis, self.nis_size = np.full(1, np.nan), np.zeros(1)
        self.arrays = (self.nis, self.nis_size)

    def connect(self, inputs):
        self.inputs = inputs

    def estimate(self, time, out):
        out[:] = self.inputs.start
        fresh = self.sensors and self.sensors[0].fresh[0]
        self.nis[0], self.nis_size[0] = (3.0, 2.0) if fresh else (np.nan, 0.0)

    def close(self):
        type(self).closed += 1


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_controllers_see_the_estimate(estimator):
    states, found = seen_states(loaded(estimator))
    estimate = np.hstack([found[f"estimated_{name}"] for name in STATE])
    assert states.tobytes() == np.ascontiguousarray(estimate).tobytes()
    assert not np.array_equal(found["estimated_position"], found.position)


def test_the_estimator_none_changes_no_bit():
    plain = cdpr.simulate(CAROCA, overrides={**SHORT, "sensors": ENCODERS})
    assert run("none").rows.tobytes() == plain.rows.tobytes()
    noisy = [{"type": "pose", "position": {"noise": 1e-3}}, {"type": "twist"}]
    plain = cdpr.simulate(CAROCA, overrides={**SHORT, "sensors": noisy})
    assert run("none", noisy).rows.tobytes() == plain.rows.tobytes()


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_snapshots_and_resets_contain_estimators(estimator):
    scenario = loaded(estimator)
    whole = cdpr.simulate(scenario)
    assert whole.interpreted == ()
    assert_restarts_give(whole.rows.tobytes(), scenario, {})


def test_snapshots_contain_estimators_in_python():
    scenario = loaded(Still)
    assert_restarts_give(cdpr.simulate(scenario).rows.tobytes(), scenario, {})


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_rollouts_have_the_bits_of_single_runs(estimator):
    seeds = list(range(10))
    columns = ["position", "estimated_position", "estimated_angular_velocity"]
    about = {**SHORT, "sensors": ENCODERS, "estimator.type": estimator}
    batch = cdpr.rollout(CAROCA, 10, vary={"simulation.seed": seeds}, overrides=about, columns=columns)
    for i in (0, 3, 9):
        single = run(estimator, **{"simulation.seed": seeds[i]})
        assert all(batch[name][i].tobytes() == np.ascontiguousarray(single[name]).tobytes() for name in columns)


@pytest.mark.parametrize("backend", installed("mujoco", "bullet", "dart"))
def test_estimates_follow_the_truth_on_all_engines(backend):
    found = run("complementary", **{"simulation.backend": backend})
    assert found.status == "finished"
    assert np.abs(found["estimated_position"] - found.position).max() < 1e-3  # noise of 0.1 mm


def test_nees_and_sigma_are_those_of_numpy():
    found = run(Still, **{"simulation.duration": 0.2, "initial.velocity": [0.1, 0.0, 0.0]})
    assert np.allclose(found["estimate_sigma"], SPREAD, rtol=1e-12)
    P = np.diag(SPREAD**2)
    P[0, 6] = P[6, 0] = 0.5 * SPREAD[0] * SPREAD[6]
    estimate = [np.asarray(found[f"estimated_{name}"]) for name in STATE]
    truth = [np.asarray(found[name]) for name in STATE]
    rotations = [Rotation.from_quat(each[1], scalar_first=True) for each in (estimate, truth)]
    error = np.hstack(
        [
            truth[0] - estimate[0],
            (rotations[0].inv() * rotations[1]).as_rotvec(),
            truth[2] - estimate[2],
            truth[3] - estimate[3],
        ]
    )
    nees = np.einsum("ki,ij,kj->k", error, np.linalg.inv(P), error)
    assert nees.max() > 1.0
    np.testing.assert_allclose(found["nees"], nees, rtol=ROUND_OFF, atol=ROUND_OFF)
    low, high = stats.chi2.ppf([0.025, 0.975], 12)
    figures = found.summary()["estimate"]
    assert figures["nees"]["mean_per_value"] == pytest.approx(nees.mean() / 12, rel=ROUND_OFF)
    assert figures["nees"]["inside_95_percent"] == np.mean((nees >= low) & (nees <= high))
    assert figures["position_error_m"]["max"] == pytest.approx(np.linalg.norm(error[:, :3], axis=1).max(), rel=1e-12)
    assert figures["nis"] == {"mean_per_value": 1.5, "inside_95_percent": 1.0, "last": 3.0, "last_values": 2.0}


def test_measurements_are_fresh_when_they_arrive():
    """A new measurement has other noise, so its values differ from those before."""
    sensors = [{"type": "receiver", "position": {"noise": 1e-3}, "period": 0.004, "jitter": 0.003, "dropout": 0.3}]
    found = run(Still, sensors, **{"simulation.duration": 0.3})
    changed = np.any(np.diff(found["receiver_position"], axis=0) != 0.0, axis=1)
    fresh = found["nis_size"] > 0.0
    assert fresh[0]
    assert np.array_equal(fresh[1:], changed)
    assert 20 < np.count_nonzero(fresh) < 80


def test_commands_are_those_before_faults():
    """The cable breaks at 10 ms; the tension distribution detects it 20 ms later."""
    commands, limits, held, times = [], [], [], []

    class Watching(Still):
        def estimate(self, time, out):
            super().estimate(time, out)
            times.append((time, self.inputs.time[0]))
            commands.append(self.inputs.command.copy())
            limits.append(self.inputs.limits[:, 0].copy())
            held.append(self.inputs.held[0])

    event = {"type": "cable_break", "time": 0.01, "cable": 1, "detected_after": 0.02}
    found = run(Watching, **{"events": [event]})
    count = len(found.time)
    sent, known = np.array(commands)[-count:], np.array(held)[-count:]
    assert np.array_equal(sent[0], np.zeros(8))
    assert np.array_equal(sent[1:11], found.tension[:10])
    assert (found.tension[10:30, 0] == 0.0).all()
    assert (sent[11:30, 0] > 0.0).all()
    assert known.tolist() == [False] * 31 + [True] * 20 or known.tolist() == [False] * 30 + [True] * 21
    assert (np.array(limits)[-1] == 0.0).all()
    assert all(one == other for one, other in times)


def test_an_assumed_start():
    start = {"position": [0.1, 0.0, 1.1], "orientation": {"rpy": [0.0, 0.0, 0.2]}}
    found = run(Still, **{"estimator.start": start})
    assert found["estimated_position"][0].tolist() == [0.1, 0.0, 1.1]
    turned = Rotation.from_quat(found["estimated_orientation"][0], scalar_first=True).as_euler("xyz")
    np.testing.assert_allclose(turned, [0.0, 0.0, 0.2], atol=1e-12)
    assert found.summary()["estimate"]["position_error_m"]["max"] > 0.05


def test_estimators_are_closed_and_described():
    before = Still.closed
    assert run(Still).status == "finished"
    assert Still.closed >= before + 2  # that of the check, and that of the loop


@pytest.mark.parametrize("facts", [{"gain": np.zeros(3)}, {"gain": np.nan}])
def test_facts_that_are_no_json_are_a_warning_and_the_run_is_kept(facts, tmp_path):
    class Describing(Still):
        def describe(self):
            return facts

    before = Still.closed
    found = cdpr.simulate(loaded(Describing), out=tmp_path / "run")
    assert next(event.text for event in found.events if "JSON" in event.text).startswith("the estimation raised ")
    assert cdpr.load_run(tmp_path / "run").status == "finished"
    assert Describing.closed >= before + 2


@pytest.mark.parametrize(
    ("estimator", "sensors", "text"),
    [
        (
            "forward_kinematics",
            [],
            "needs a sensor of the type encoders; the scenario has none: add `- type: encoders`",
        ),
        ("complementary", [{"type": "encoders"}], "needs a sensor of the type imu; the scenario has encoders"),
        ("complementary", [{"type": "imu"}], "add a sensor of the type pose or encoders"),
        ("kalman", [], "no estimator is named 'kalman'"),
    ],
)
def test_missing_sensors_are_named(estimator, sensors, text):
    with pytest.raises(CdprError, match=text):
        run(estimator, sensors)


def test_wrong_options_are_named():
    with pytest.raises(ScenarioError, match=r"estimator\.filter_times: unknown key"):
        run("forward_kinematics", **{"estimator.filter_times": 1.0})
    slow = [{"type": "imu"}, {"type": "pose", "period": 0.005}]
    with pytest.raises(CdprError, match=r"estimator\.bandwidth: expected at most 100"):
        run("complementary", slow, **{"estimator.bandwidth": 200.0})
    with pytest.raises(CdprError, match=r"estimator\.bias_gain: expected at most 500 with attitude_gain 5"):
        run("complementary", slow, **{"estimator.bias_gain": 501.0})
    with pytest.raises(ScenarioError, match=r"estimator\.noise_floor: must be at least 1e-12"):
        run("ekf", [{"type": "encoders"}], **{"estimator.noise_floor": 1e-200})


def test_a_filter_without_any_noise_is_finite():
    """Exact sensors and start, and no unknown wrench: all variances are those of the least noise."""
    names = ["force_noise", "moment_noise", "position_error", "rotation_error", "velocity_error", "turn_rate_error"]
    options = {f"estimator.{name}": 0.0 for name in names}
    found = run("ekf", [{"type": "encoders"}], **options, **{"estimator.noise_floor": 1e-12})
    assert found.status == "finished"
    assert np.isfinite(found["estimate_sigma"]).all()


def test_undeclared_covariance_is_rejected():
    class Silent(Still):
        properties = {"sensors": ()}  # noqa: RUF012

    with pytest.raises(PluginError, match="its attribute covariance does not agree with its declared properties"):
        run(Silent)


def test_an_estimate_that_is_not_finite_ends_the_run():
    class Lost(Still):
        def estimate(self, time, out):
            super().estimate(time, out)
            out[0] = np.nan if time > 0.02 else out[0]

    with pytest.raises(Diverged, match=r"t = 0.021 s: the state that .* sees is not finite; .*'estimation'"):
        run(Lost)


@pytest.mark.parametrize("scale", [0.0, 1.001])
def test_a_quaternion_without_the_norm_1_ends_the_run(scale):
    class Grown(Still):
        def estimate(self, time, out):
            super().estimate(time, out)
            out[3:7] *= scale if time > 0.02 else 1.0

    with pytest.raises(
        PluginError, match=r"t = 0.021 s: the estimator 'Grown' wrote the quaternion .*: expected the n"
    ):
        run(Grown)


def _entry(i, j, value):
    """Return a change of an entry of a covariance."""

    def change(covariance):
        covariance[i, j] = value

    return change


@pytest.mark.parametrize("change", [_entry(1, 0, 1e3), _entry(0, 1, 1e3), _entry(2, 2, -1e-9)])
def test_a_matrix_that_is_no_covariance_has_no_nees(change):
    class Lopsided(Still):
        def estimate(self, time, out):
            super().estimate(time, out)
            change(self.covariance)

    assert np.isnan(run(Lopsided)["nees"]).all()


def test_a_pose_without_a_twist_suffices_for_an_estimator():
    assert run("complementary", [{"type": "imu"}, {"type": "pose"}]).status == "finished"


def test_resolved_scenarios_contain_the_estimator():
    text = loaded("forward_kinematics").resolved_yaml()
    assert "estimator:\n  type: forward_kinematics\n  filter_time: 0.0" in text
    assert "estimator" not in cdpr.load_scenario(CAROCA).resolved_yaml()


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_believed_errors_that_no_estimator_uses_are_rejected(estimator):
    sensors = [{**ENCODERS[0], "believed": {"length": {"noise": 2e-4}}}, ENCODERS[1]]
    assert loaded(estimator, sensors).estimator is not None
    for key in ("bias", "drift", "gain"):
        given = [{**ENCODERS[0], "believed": {"length": {key: 0.1}}}, ENCODERS[1]]
        text = rf"sensors\[0\].believed.length.{key}: the estimator '{estimator}' does not use it: remove this key"
        with pytest.raises(CdprError, match=text):
            run(estimator, given)
