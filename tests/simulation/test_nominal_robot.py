"""Runs whose controller and solver believe the robot to be another: who gets which robot, and what follows."""

from __future__ import annotations

import json

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT
from plants import installed

import cdpr
from cdpr.analysis.compare.finished import compare_finished
from cdpr.base.errors import Diverged
from cdpr.mechanics.kinematics import lengths, wrench_matrix
from cdpr.plugins import Controller
from cdpr.scenario import load_scenario
from cdpr.simulation.build import build
from cdpr.tension import Status
from cdpr.ui.report.pages.run import render
from cdpr.ui.report.text.reservations import reservations

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
WINCH = str(ROOT / "scenarios" / "winch.yaml")
BELIEVED = str(ROOT / "scenarios" / "believed.yaml")
SHORT = {"simulation.duration": 0.1}
KP = 100.0  # of the scenarios, 1/s^2

# A second after the end of its motion the error, critically damped at 10 rad/s, has shrunk by exp(-10) (1 + 10) = 5e-4
# of what the motion left of it, which is at most a hundredth of the steady error; measured 3e-9 of that.
SETTLED = 1e-6

# Sums of eight products of a thousand newtons at most.
ROUND_OFF = 1e-9

HOLD = {"trajectory": {"type": "hold"}, "simulation.duration": 4.0, "simulation.control_step": 0.004}


def states(run):
    return np.hstack([run.position, run.orientation, run.velocity, run.angular_velocity])


@pytest.mark.parametrize("file", [CAROCA, WINCH, str(ROOT / "scenarios" / "planar.yaml")])
@pytest.mark.parametrize("controller", ["computed_torque", "cable_length"])
def test_to_believe_the_truth_changes_no_bit(file, controller):
    plain = cdpr.simulate(file, controller=controller, overrides=SHORT)
    run = cdpr.simulate(file, controller=controller, overrides={**SHORT, "believed": {}})
    width = plain.rows.shape[1]
    assert np.ascontiguousarray(run.rows[:, :width]).tobytes() == plain.rows.tobytes()
    assert run.rows.shape[1] == width + 6 + plain.tension.shape[1]
    assert (plain.header.believed, run.header.believed) == ("", "the robot without changes")
    assert np.array_equal(run.true_wrench, run["true_wrench"])
    with pytest.raises(AttributeError, match="recorded only if the scenario has `believed`, an estimator or sensors"):
        _ = plain.true_wrench
    assert "believed" not in plain.header.to_dict()


@pytest.mark.parametrize("mass", [140.0, 165.0])
def test_a_wrong_mass_causes_the_predicted_error(mass):
    """At rest m_b (kp e - g) = -m g, so that e = (m - m_b) |g| / (m_b kp), upwards."""
    run = cdpr.simulate(CAROCA, overrides={**HOLD, "believed.platform.mass": mass})
    expected = (150.0 - mass) * 9.81 / (mass * KP)
    assert run.position_error[-1] == pytest.approx([0.0, 0.0, expected], abs=SETTLED * abs(expected))
    assert run["true_wrench"][-1] == pytest.approx([0, 0, 150 * 9.81, 0, 0, 0], rel=1e-6, abs=1e-4)
    assert run.header.mass == 150.0


def test_wrong_anchors_change_the_distribution_but_not_the_plant():
    scenario = load_scenario(BELIEVED, overrides=HOLD)
    run = cdpr.simulate(scenario)
    for k in (0, 10, len(run.rows) - 1):
        x = states(run)[k]
        nominal, true = (wrench_matrix(robot, x) @ run.tension[k] for robot in (scenario.nominal, scenario.robot))
        assert np.abs(nominal - run.wrench[k]).max() < ROUND_OFF
        assert np.abs(true - run["true_wrench"][k]).max() < ROUND_OFF
        assert np.abs(true - nominal).max() > 1.0
        assert run.length[k] == pytest.approx(lengths(scenario.robot, x), abs=1e-12)
    assert run.residual.max() < ROUND_OFF
    # At rest, the true wrench balances the true weight.
    assert run["true_wrench"][-1] == pytest.approx([0, 0, 150 * 9.81, 0, 0, 0], rel=1e-6, abs=1e-4)


def test_each_gets_its_robot():
    scenario = load_scenario(BELIEVED, overrides={"controlled": ["x", "y", "z"]})
    parts = build(scenario)
    assert parts.backend.robot is scenario.robot is parts.robot
    assert parts.controller.robot is scenario.nominal is parts.nominal
    assert parts.controlled_robot.dof == ("x", "y", "z")
    assert parts.controlled_robot.anchors.tolist() == scenario.nominal.anchors.tolist()
    parts.backend.close()


def test_cables_are_measured_as_they_are():
    class Spy(Controller):
        """carries the weight"""

        def sense(self, cables):
            self.cables = cables

        def control(self, time, state, desired, out):
            seen.append(self.cables.copy())
            out[:] = 0.0
            out[2] = 9.81 * self.robot.platform.mass

    seen: list[np.ndarray] = []
    run = cdpr.simulate(BELIEVED, controller=Spy, overrides=SHORT)
    assert np.array_equal(np.array(seen[1:])[:, 0], run.length)  # the first call warms up
    assert np.array_equal(np.array(seen[1:])[:, 1], run.rate)
    assert run.wrench[0, 2] == 9.81 * 140


def test_control_of_lengths_meets_true_lengths_with_believed_ones():
    """The difference of two commands by their gains alone: kp (true length - length believed at the desired pose)."""
    scenario = load_scenario(BELIEVED)
    first = {}
    for kp in (0.0, 1000.0):
        options = {"kp": kp, "kd": 0.0, "ki": 0.0, "forward_kinematics": False}
        changes = {f"controller.{key}": value for key, value in options.items()}
        with cdpr.Simulation(BELIEVED, controller="cable_length", overrides=changes) as sim:
            sim.step()
            first[kp] = sim.tension
            x = sim.scenario.initial.state()
    error = lengths(scenario.robot, x) - lengths(scenario.nominal, x)
    assert np.abs(error).max() > 0.005
    assert first[1000.0] - first[0.0] == pytest.approx(1000.0 * error, abs=ROUND_OFF)


def test_elastic_cables_exert_what_they_feel():
    scenario = load_scenario(WINCH, overrides={"believed.cables[0].frame[2]": 3.6, **SHORT})
    run = cdpr.simulate(scenario)
    k = len(run.rows) // 2
    true = wrench_matrix(scenario.robot, states(run)[k]) @ run.cable_tension[k]
    assert np.abs(true - run["true_wrench"][k]).max() < ROUND_OFF


def test_limits_are_believed_and_faults_are_true():
    """The solver keeps to believed limits, limits of an event reach it, and a cable that breaks is broken."""
    events = [
        {"type": "limits", "time": 0.02, "min": 50.0, "max": 900.0},
        {"type": "cable_break", "time": 0.05, "cable": 2, "detected_after": 0.02},
    ]
    changes = {**SHORT, "events": events, "believed.tension.min": 360, "believed.cables[1].frame[2]": 3.52}
    scenario = load_scenario(CAROCA, overrides=changes)
    run = cdpr.simulate(scenario)
    assert run.tension[:20].min() == pytest.approx(360.0)
    assert run.margin[:20].min() == pytest.approx(0.0, abs=1e-6)
    assert run.header.tension_min == (50.0,) * 8
    assert (run.tension[50:, 1] == 0.0).all()
    assert (run.tension[20:, :] <= 900.0 + 1e-6).all()
    k = 60  # broken, and the distribution has not yet learnt of it: in belief the cable misses, in truth too
    true = wrench_matrix(scenario.robot, states(run)[k]) @ run.tension[k]
    assert np.abs(true - run["true_wrench"][k]).max() < ROUND_OFF
    assert run.residual[k] > 50.0


def test_a_sample_without_tensions_is_whole():
    changes = {**SHORT, "solver.infeasible": "stop", "believed.tension.min": 3000}
    with pytest.raises(cdpr.Infeasible) as stopped:
        cdpr.simulate(CAROCA, overrides=changes)
    run = stopped.value.run
    assert run.solver_status[-1] == Status.INFEASIBLE
    scenario = load_scenario(CAROCA, overrides=changes)
    true = wrench_matrix(scenario.robot, states(run)[-1]) @ run.tension[-1]
    assert np.abs(true - run["true_wrench"][-1]).max() < ROUND_OFF


def test_a_believed_cable_without_length_ends_the_run():
    """The motion moves an anchor of the nominal platform through that of the frame."""
    changes = {"believed.cables": [{"name": "cable_1", "frame": [0.6, -0.3, 1.02], "platform": [0.6, -0.3, -0.2]}]}
    motion = {"trajectory": {"type": "hold"}, "initial.position": [0, 0, 1.23], "initial.velocity": [0, 0, -1.0]}
    fall = {"controller.kp": 0, "controller.kd": 0, "world.gravity": [0, 0, 0], "simulation.control_step": 0.01}
    duration = {"simulation.duration": 0.1, "simulation.physics_step": 0.01, "solver.infeasible": "hold_tension"}
    slack = {"robot.tension.min": 0, "solver.type": "pseudo_inverse", "robot.unilateral": False}
    with pytest.raises(
        Diverged, match="of the controller's nominal robot has no length: of 'cable_1' its ends lie in one point"
    ):
        cdpr.simulate(CAROCA, overrides={**motion, **fall, **duration, **slack, **changes})


@pytest.mark.parametrize("controller", ["computed_torque", "cable_length"])
def test_a_branch_continues_to_the_bit(controller):
    events = [{"type": "cable_jam", "time": 0.05, "cable": 1, "detected_after": 0.004}]
    changes = {**SHORT, "events": events}
    whole = cdpr.simulate(BELIEVED, controller=controller, overrides=changes)
    with cdpr.Simulation(BELIEVED, controller=controller, overrides=changes) as sim:
        sim.step(30)
        here = sim.snapshot()
        sim.step(30, wrench=[0, 0, 900, 0, 0, 0])
        sim.restore(here)
        while not sim.done:
            sim.step()
        assert sim.run().rows.tobytes() == whole.rows.tobytes()
        sim.reset()
        sim.step(len(whole.rows))
        assert sim.run().rows.tobytes() == whole.rows.tobytes()


@pytest.mark.parametrize("backend", installed("mujoco", "bullet", "dart"))
def test_every_engine_moves_the_true_robot(backend):
    changes = {**SHORT, "backend_options.reference.scheme": "semi_implicit_euler"}
    ours = cdpr.simulate(BELIEVED, overrides=changes)
    run = cdpr.simulate(BELIEVED, backend=backend, overrides=SHORT)
    assert np.abs(run.position - ours.position).max() < 1e-9


def test_it_is_reported_with_every_run_summary(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = "platform.mass 140 kg instead of 150"
    given = (CAROCA, "--set", "believed.platform.mass=140", "--set", "simulation.duration=0.05")
    said = cdpr_here("run", *given, "--out", "one", "--no-report").stdout
    assert f"believed            {line}" in said
    told = json.loads((tmp_path / "one" / "run.json").read_text())
    assert told["summary"]["believed"] == told["header"]["believed"] == line
    run = cdpr.load_run("one")
    assert run.header.believed == line
    assert run["true_wrench"].shape == (51, 6)
    assert line in render(run)
    assert json.loads(cdpr_here("validate", *given, "--json").stdout)[0]["believed"] == line
    info = cdpr_here("info", *given).stdout
    assert f"nominal model        {line}" in info
    assert "platform             150 kg" in info
    exported = cdpr_here("export", "one", "--to", "csv")
    assert exported.returncode == 0
    (table,) = (tmp_path / "one").glob("*.csv")
    assert "true_wrench_force_z_N" in table.read_text().splitlines()[0]
    cdpr_here("run", CAROCA, "--set", "simulation.duration=0.05", "--out", "two", "--no-report")
    verdict = compare_finished(["one", "two"]).groups[0].rows[0].verdict
    assert "believed" in verdict.reason


def test_an_exported_plant_is_the_true_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, changes in (("true", ()), ("believed", ("--set", "believed.platform.mass=140"))):
        cdpr_here("fmu", "export", CAROCA, *changes, "-o", f"{name}.fmu", "--source-only")
    assert (tmp_path / "true.fmu").read_bytes() == (tmp_path / "believed.fmu").read_bytes()


# caroca's cables hold the platform with up to 457 N: more than some may, which the controller does not know.
WEAK = {**SHORT, "robot.tension.max": 400, "believed.tension.max": 10000}


def test_commands_beyond_the_true_limits_are_counted_and_reported():
    run = cdpr.simulate(CAROCA, overrides=WEAK)
    beyond = run["tension"] > 400.0
    assert beyond.any(axis=1).all()
    assert not beyond.all()
    assert run.summary()["beyond_limits_steps"] == {"below_min": 0, "above_max": 101}
    assert np.array_equal(run["true_margin"], np.minimum(run.tension - 50.0, 400.0 - run.tension))
    worst = run.header.cables[int(run.tension.max(axis=0).argmax())]
    told = f"commands that require tensions above tension.max: {worst} up to {run.tension.max():.4g} of 400 N, and "
    assert next(event.text for event in run.events if event.kind == "limit").startswith(told)
    assert list(reservations(run)) == ["101 of 101 samples had commands that require tensions above tension.max"]


def test_so_they_are_of_a_log_that_is_thinned_and_on_disk(tmp_path):
    run = cdpr.simulate(CAROCA, overrides={**WEAK, "log.step": 0.01}, out=tmp_path / "run")
    assert len(run.rows) == 11
    assert run.summary()["beyond_limits_steps"] == {"below_min": 0, "above_max": 101}


def test_limits_stop_where_they_are_left(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = (f"--set={key}={value}" for key, value in (WEAK | {"limits": "stop"}).items())
    done = cdpr_here("run", CAROCA, *given, "--out", "run", "--no-report", code=4)
    assert "t = 0 s: commands that require tensions above tension.max: " in done.stderr
    assert cdpr.load_run("run").status == "beyond_limits"


def test_broken_cables_and_event_limits_are_no_violations():
    looser = {"type": "limits", "time": 0.02, "max": 500}
    cut = {"type": "cable_break", "time": 0.05, "cable": 1}
    run = cdpr.simulate(CAROCA, overrides={**WEAK, "events": [looser, cut]})
    assert run.summary()["beyond_limits_steps"]["above_max"] == 20
    assert np.isnan(run["true_margin"][50:, 0]).all()
    assert run.summary()["beyond_limits_steps"]["below_min"] == 0
    with cdpr.Simulation(CAROCA, overrides=WEAK) as sim:
        sim.limits(max=500)
        here = sim.snapshot()
        sim.step(3)
        sim.limits(max=9000)
        sim.restore(here)
        while not sim.done:
            sim.step()
        assert sim.run().summary()["beyond_limits_steps"]["above_max"] == 0
