"""Controllers with preview, live limits, held cables and a period of their own: a small predictive one."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pytest

import cdpr
from cdpr.base.errors import CdprError, PluginError
from cdpr.mechanics import dynamics, kinematics
from cdpr.model import rotations
from cdpr.native.bind import bind
from cdpr.plugins import Controller, SnapshotOfArrays
from cdpr.plugins.controller import Tunable
from cdpr.simulation.exported import control_of
from cdpr.simulation.start import chosen_scenario
from cdpr.testing import check_factory
from cdpr_controllers import ComputedTorqueOptions
from cdpr_controllers.computed_torque import ComputedTorque

HORIZON, PERIOD = 5, 10  # predicted steps; control steps between two calls


def prediction(step):
    """Least-squares gain from errors at the predicted times to the first acceleration."""
    ahead = np.arange(1, HORIZON + 1)
    effect = np.maximum(ahead[:, None] - np.arange(HORIZON) - 0.5, 0.0) * step**2
    weight = 0.05 * step**2 * np.eye(HORIZON)
    return np.linalg.pinv(np.vstack([effect, weight]))[0, :HORIZON]


def distribute(W, wrench, low, high):
    """Tensions within the limits that balance a wrench, by alternating projections from the lower limits."""
    inverse, tension = np.linalg.pinv(W * (low < high)), low.copy()
    for _ in range(100):
        tension = np.clip(tension + inverse @ (wrench - W @ tension), low, high)
    return tension


class Predictive(SnapshotOfArrays, Controller):
    """Predictive control of acceleration over five steps, with its own distribution of tensions."""

    properties: ClassVar = {"output": "tension"}
    period = PERIOD

    def __init__(self, *given):
        super().__init__(*given)
        self.step = PERIOD * self.control_step
        self.gain = prediction(self.step)
        self.calls = np.zeros(1)
        self.arrays = (self.calls,)

    def observe(self, inputs):
        self.inputs = inputs

    def reset(self):
        self.calls[:] = 0.0

    def limits(self):
        return self.inputs.limits

    def control(self, time, state, desired, out):
        self.calls += 1.0
        if not np.isfinite(state).all():
            out[:] = np.nan
            return
        after = self.step * np.arange(1, HORIZON + 1)
        target = self.inputs.preview(time + after)
        error = np.empty((HORIZON, 6))
        error[:, :3] = target[:, :3] - state[:3] - after[:, None] * state[7:10]
        for k, pose in enumerate(target[:, 3:7]):
            turn = rotations.multiply(pose, rotations.conjugate(state[3:7]))
            error[k, 3:] = 2.0 * np.copysign(1.0, turn[0]) * turn[1:] - after[k] * state[10:13]
        acceleration = self.gain @ error
        wrench = dynamics.required_wrench(self.robot, state, self.gravity, acceleration[:3], acceleration[3:])
        out[:] = distribute(kinematics.wrench_matrix(self.robot, state), wrench, *self.limits())


class Blind(Predictive):
    """The same without knowledge of faults."""

    def limits(self):
        return self.robot.tension_min, self.robot.tension_max


def distance(run):
    return np.linalg.norm(run.position - run.desired_position, axis=1)


def test_it_tracks_and_is_called_once_a_period():
    with cdpr.Simulation("caroca", controller=Predictive, overrides={"simulation.duration": 1.0}) as sim:
        sim.until(1.0)
        calls, run = sim._loop.parts.controller.calls[0], sim.run()
    assert distance(run).max() < 1e-4
    assert calls == len(run.time) // PERIOD + 1
    assert (run.tension[1:PERIOD] == run.tension[0]).all()
    assert (run.tension[PERIOD] != run.tension[0]).any()


BREAK = [{"type": "cable_break", "time": 0.253, "cable": "cable_2", "detected_after": 0.01}]


@pytest.mark.slow
def test_it_knows_of_a_broken_cable_once_that_is_detected():
    knowing, blind = (
        cdpr.simulate("caroca", controller=each, overrides={"simulation.duration": 1.5, "events": BREAK})
        for each in (Predictive, Blind)
    )
    assert distance(knowing).max() < 1e-2
    assert distance(knowing)[-1] < 1e-5 < 1e-4 < distance(blind)[-1]
    detected = np.searchsorted(knowing.time, 0.27 - 1e-9)  # its first call after that
    assert (knowing.tension[detected:, 1] == 0.0).all()


class Watching(Controller):
    """Constant wrench, with a record of the inputs."""

    seen: list

    def observe(self, inputs):
        self.inputs, self.seen = inputs, []
        Watching.last = self

    def control(self, time, state, desired, out):
        known = self.inputs
        self.seen.append((time, known.limits.copy(), known.held.copy(), known.command.copy()))
        out[:] = 0.0
        out[:3] = -self.robot.platform.mass * self.gravity


def watched(events, duration=0.02, **more):
    run = cdpr.simulate(
        "caroca", controller=Watching, overrides={"simulation.duration": duration, "events": events, **more}
    )
    return run, Watching.last.seen[-len(run.time) :]


def test_held_cables_and_limits_follow_detection_not_the_fault():
    _, seen = watched([{"type": "cable_break", "time": 0.005, "cable": 3, "detected_after": 0.004}])
    held = [each[2][2] for each in seen]
    assert held == [False] * 9 + [True] * 12
    assert (seen[8][1][:, 2] == [50.0, 10000.0]).all()
    assert (seen[9][1][:, 2] == 0.0).all()
    assert not any(each[2][[0, 1, 3, 4, 5, 6, 7]].any() for each in seen)


def test_the_previous_command_is_that_sent_before_the_fault_acts_on_it():
    run, seen = watched([{"type": "cable_break", "time": 0.005, "cable": 3, "detected_after": 0.004}])
    assert (seen[0][3] == 0.0).all()
    for k in range(1, 5):
        assert (seen[k][3] == run.tension[k - 1]).all()
    assert run.tension[6, 2] == 0.0
    assert seen[7][3][2] >= 50.0  # sent, but the cable is broken
    assert seen[11][3][2] == 0.0


def test_without_power_the_previous_command_is_the_last_one_sent():
    run, seen = watched([{"type": "emergency_stop", "time": 0.005, "category": 0}])
    assert (run.tension[5:] == 0.0).all()
    assert all((each[3] == run.tension[4]).all() for each in seen[5:])


def test_limits_change_with_events():
    _, seen = watched([{"type": "limits", "time": 0.01, "max": 900.0}])
    assert {each[1][1].max() for each in seen[:10]} == {10000.0}
    assert {each[1][1].max() for each in seen[10:]} == {900.0}


def test_inputs_are_read_only():
    watched([])
    inputs = Watching.last.inputs
    for array in (inputs.limits, inputs.held, inputs.command):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0.0
    assert dict(inputs.measurements) == {}


def test_preview_is_the_desired_motion_also_after_a_new_target():
    with cdpr.Simulation("caroca", controller=Watching, overrides={"simulation.duration": 1.0}) as sim:
        preview = Watching.last.inputs.preview
        assert preview(np.array([])).shape == (0, 19)
        before = preview([0.5])
        assert before.shape == (1, 19)
        sim.until(0.1)
        sim.target([0.1, 0.0, 1.2], duration=0.5)
        after = preview([0.5])
        assert (after != before).any()
        sim.until(1.0)
        run = sim.run()
    assert run.desired_position[500] == pytest.approx(after[0, :3], abs=1e-12)


STOP = [{"type": "emergency_stop", "time": 0.05, "stopping_time": 0.1}]


def test_preview_does_not_know_of_later_events():
    plain, before, after = ([], [], [])
    for found, events in ((plain, []), (before, STOP), (after, STOP)):
        with cdpr.Simulation("caroca", controller=Watching, overrides={"events": events}) as sim:
            sim.until(0.05 if found is after else 0.049)
            found.append(Watching.last.inputs.preview([0.04, 0.3]))
            motion = sim.scenario.desired
    assert np.array_equal(before, plain)
    assert np.array_equal(after[0], [motion.sample(0.04), motion.sample(0.3)])
    assert (after[0] != plain[0]).any()


@pytest.mark.slow
@pytest.mark.parametrize("kind", [Predictive, type("Each", (Predictive,), {"period": 1})])
def test_sessions_with_new_targets_have_the_same_bits(kind, tmp_path):
    with cdpr.Simulation("caroca", controller=kind, overrides={"simulation.duration": 0.16}) as sim:
        sim.until(0.04)
        sim.target([0.1, 0.0, 1.2], duration=0.5)
        sim.until(0.08)
        sim.step(9, wrench=[0, 0, 1500, 0, 0, 0])
        sim.stop(stopping_time=0.05)
        sim.until(0.16)
        sim.save(tmp_path / "session.yaml")
        live = sim.run()
    assert cdpr.simulate(tmp_path / "session.yaml", controller=kind).rows.tobytes() == live.rows.tobytes()


@pytest.mark.parametrize("times", [np.zeros((2, 2)), [np.nan], ["soon"]])
def test_invalid_times_of_the_preview_are_rejected(times):
    watched([])
    with pytest.raises(CdprError, match=r"^preview: times: "):
        Watching.last.inputs.preview(times)


@pytest.mark.parametrize("period", [1, 10])
@pytest.mark.parametrize("written", [0, 3])
def test_incomplete_outputs_are_rejected(period, written):
    def control(self, time, state, desired, out):
        out[:written] = 1.0

    kind = type("Incomplete", (Watching,), {"period": period, "control": control})
    with pytest.raises(PluginError, match="wrote no wrench, or NaN: `control` must write all of"):
        cdpr.simulate("caroca", controller=kind)


def test_snapshots_keep_the_phase_of_the_period():
    with cdpr.Simulation("caroca", controller=Predictive, overrides={"simulation.duration": 0.3}) as sim:
        sim.until(0.063)  # within a period
        middle = sim.snapshot()
        sim.until(0.2)
        first = sim.so_far().tension.tobytes()
        sim.restore(middle)
        sim.until(0.2)
        assert sim.so_far().tension.tobytes() == first
        sim.reset()
        sim.until(0.2)
        assert sim.so_far().tension.tobytes() == first


def test_an_output_held_after_external_commands_is_the_controllers_own():
    class Slow(Controller):
        period = 10

        def control(self, time, state, desired, out):
            out[:] = 0.0
            out[:3] = -self.robot.platform.mass * self.gravity

    with cdpr.Simulation("caroca", controller=Slow, overrides={"simulation.duration": 0.02}) as sim:
        sim.step(4, wrench=[0, 0, 1500, 0, 0, 0])
        sim.step(2)
        sim.step(1, wrench=[0, 0, 1400, 0, 0, 0])
        sim.step(1)
        wrench = sim.run().wrench[:, 2]
    weight = 150 * 9.81
    assert wrench == pytest.approx([1500.0] * 4 + [weight] * 2 + [1400.0, weight], rel=1e-6)


class Five(Controller):
    """A compiled law, called every five control steps."""

    period = 5

    def __init__(self, *given):
        super().__init__(*given)
        self.values = np.zeros(6)

    def control(self, time, state, desired, out):
        out[:] = [0.0, 0.0, 1471.5 + 1000.0 * time, 0.0, 0.0, 0.0]

    def compiled(self, state, desired, out):
        return bind("copy", source=self.values, target=out)


def test_a_period_also_holds_for_a_compiled_law():
    run = cdpr.simulate("caroca", controller=Five, overrides={"simulation.duration": 0.02})
    assert run.wrench[:, 2] == pytest.approx(1471.5 + 5.0 * (np.arange(21) // 5))


@pytest.mark.parametrize("output", ["length", "rate"])
def test_outputs_that_no_winch_accepts_are_rejected(output):
    kind = type("Winding", (Watching,), {"properties": {"output": output}})
    text = f"outputs a {output} for each cable, but the winches of this robot take a tension: choose a controller"
    with pytest.raises(PluginError, match=text):
        cdpr.simulate("caroca", controller=kind)


@pytest.mark.parametrize("period", [0, 2.0, True, None])
def test_invalid_periods_are_rejected(period):
    with pytest.raises(PluginError, match=r"Odd\.period: expected a whole number of control steps, at least 1, got"):
        cdpr.simulate("caroca", controller=type("Odd", (Watching,), {"period": period}))


@pytest.mark.parametrize(
    ("kind", "reason"),
    [(Predictive, "has a period of several control steps"), (Watching, "has no compiled operation")],
)
def test_they_cannot_be_exported(kind, reason):
    with pytest.raises(CdprError, match=reason):
        control_of(chosen_scenario("caroca", {"controller": kind}, None))


class Adding(ComputedTorque):
    """Computed torque whose inner loop, in Python, adds 10 N to each tension."""

    Options = ComputedTorqueOptions

    def inner_loop(self, distributed, tension):
        def correct(time):
            tension[:] = distributed + 10.0

        return correct


def test_an_inner_loop_in_python_corrects_the_distributed_tensions():
    """Also after a restart; events act on what it sends."""
    options = {"controller": Adding, "overrides": {"simulation.duration": 0.05}}
    options["overrides"] |= {"events": [{"type": "cable_break", "time": 0.03, "cable": "cable_2"}]}
    corrected, plain = cdpr.simulate("caroca", **options), cdpr.simulate("caroca", overrides=options["overrides"])
    np.testing.assert_allclose(corrected.tension[0], plain.tension[0] + 10.0)
    assert corrected.tension[-1, 1] == 0.0
    assert corrected.interpreted == ("controller",)
    with pytest.raises(CdprError, match="corrects the distributed tensions"):
        control_of(chosen_scenario("caroca", {"controller": Adding}, None))


def test_options_in_scattered_elements_cannot_be_exported(monkeypatch):
    def tunable(self):
        gains = self._given["gains"][::2]
        return {"kp": Tunable(gains, gains.copy())}

    monkeypatch.setattr(ComputedTorque, "tunable", tunable)
    with pytest.raises(PluginError, match="the array of the option 'kp' in `tunable` is not contiguous"):
        control_of(chosen_scenario("caroca", {}, None))


def test_the_kit_checks_them():
    checks = ["period_is_whole", "inputs_may_change", "reset_forgets", "snapshot_restores"]
    results = check_factory("controller", Predictive, properties=Predictive.properties, only=checks)
    assert {result.id: result.outcome for result in results} == dict.fromkeys(checks, "passed")
