"""Requirements on cables, drums and motors."""

from __future__ import annotations

import json

import numpy as np
import pytest
from conftest import ROOT
from spread import sampled
from workspace_cases import cli, robot_of

import cdpr
from cdpr.analysis.distribution import distribute
from cdpr.analysis.sizing import Duty, demands, over_workspace, sizing, with_one_broken
from cdpr.analysis.sizing.demands import _torque, drum_turns
from cdpr.analysis.workspace import box, ellipsoid, region
from cdpr.base.errors import CdprError
from cdpr.cables.drums import drum_motion
from cdpr.scenario import load_scenario

CAROCA = ROOT / "scenarios" / "caroca.yaml"

SHORT = {"simulation.duration": 1.0}
GRAVITY = np.array([0.0, 0.0, -9.81])


@pytest.fixture(scope="module")
def run():
    return cdpr.simulate("scenarios/caroca.yaml", overrides=SHORT)


@pytest.fixture(scope="module")
def foreseen():
    return Duty.of_scenario(cdpr.load_scenario("scenarios/caroca.yaml"), "foreseen")


def made(robot, tension, rate, time, length=None, feasible=None):
    shape = len(time), robot.m
    length = np.ones(shape) if length is None else length
    feasible = np.ones(len(time), dtype=bool) if feasible is None else feasible
    poses, wrenches = np.tile([0.0] * 3 + [1.0] + [0.0] * 3, (len(time), 1)), np.zeros((len(time), 6))
    return Duty("made", robot, np.broadcast_to(tension, shape), length, feasible, time, rate, poses, wrenches)


def test_figures_of_a_motion_that_is_known():
    """Lengths that swing as a sine under a constant tension: every figure in closed form."""
    robot, time = robot_of("caroca"), np.linspace(0.0, 2.0, 20001)
    w, a, T = 2 * np.pi, 0.1, 200.0
    swing = np.tile(np.sin(w * time)[:, None], (1, robot.m))
    rate = np.tile(a * w * np.cos(w * time)[:, None], (1, robot.m))
    found = demands(made(robot, T, rate, time, 3.0 + a * swing))
    expected = {
        "tension": T,
        "tension_rms": T,
        "tension_least": T,
        "speed": a * w,
        "acceleration": a * w * w,
        "driving": T * a * w,
        "braking": T * a * w,
        "given": 4 * T * a,  # two periods, in each of which the length shrinks by 2 a
        "taken": 4 * T * a,
        "shortest": 3.0 - a,
        "longest": 3.0 + a,
    }
    for name, value in expected.items():
        assert getattr(found, name) == pytest.approx(value, rel=1e-5), name
    for name in ("turns", "drum_speed", "torque", "torque_rms", "motor_power"):
        assert np.isnan(getattr(found, name)).all()


def test_the_energy_of_all_cables_is_their_work(run):
    found = demands(Duty.of_run(run, "run"))
    # A tension is held for a period, and counted as if it went straight to the next: to the share of a period.
    assert (found.given - found.taken).sum() == pytest.approx(run.cable_work[-1], rel=1e-3)
    assert found.tension == pytest.approx(run.cable_tension.max(axis=0))
    assert found.tension_least == pytest.approx(run.cable_tension.min(axis=0))


def test_motor_torque_equals_the_simulated_winch_command():
    """Of `winch` cables the command is a torque over the radius: inertia and friction are in it."""
    run = cdpr.simulate("scenarios/winch.yaml", overrides=SHORT)
    duty = Duty.of_run(run, "run")
    radius = np.array([cable.winch.drum_radius for cable in duty.robot.cables])
    acceleration = np.gradient(duty.rate, duty.time, axis=0)
    torque = _torque(duty.robot, duty.tension, drum_motion(duty.robot, duty.length, duty.rate, acceleration))
    told, beyond = radius * run.tension, np.abs(radius * run.cable_tension - radius * run.tension)
    moving = slice(200, -10)  # the first samples settle
    assert np.abs(torque - told)[moving].max() < 0.1 * beyond[moving].max()


def test_turns_of_a_drum():
    duty = Duty.of_scenario(cdpr.load_scenario("scenarios/winch.yaml"), "winch")
    found = demands(duty)
    radius = duty.robot.cables[0].winch.drum_radius
    assert found.turns[0] * 2 * np.pi * radius == pytest.approx(np.ptp(duty.length[:, 0]))
    assert found.drum_speed[0] * radius == pytest.approx(np.abs(duty.rate[:, 0]).max())


def test_gear_and_losses_are_in_the_figures_of_motors():
    """Slow winding in at a constant tension: torque r T / (e N) and speed N w at the motor's shaft, power r T w / e."""
    changes = {"robot.winch": {"drum_radius": 0.05, "inertia": 0.002, "efficiency": 0.8, "gear_ratio": 20.0}}
    robot = cdpr.load_scenario("scenarios/winch.yaml", overrides=changes).robot
    time = np.linspace(0.0, 2.0, 21)
    rate = np.full((21, robot.m), -0.5)
    found = demands(made(robot, 300.0, rate, time, 3.0 + rate * time[:, None]))
    assert found.torque == pytest.approx(0.05 * 300.0 / 0.8)
    assert found.motor_torque == pytest.approx(0.05 * 300.0 / 0.8 / 20.0)
    assert found.motor_torque_rms == pytest.approx(found.motor_torque)
    assert found.motor_speed == pytest.approx(20.0 * 0.5 / 0.05)
    assert found.motor_power == pytest.approx(300.0 * 0.5 / 0.8)
    assert found.turns == pytest.approx(1.0 / (2.0 * np.pi * 0.05))


def test_a_run_is_sized_as_its_motion_was_foreseen(foreseen):
    run = cdpr.simulate("scenarios/caroca.yaml")
    asked, done = demands(foreseen), demands(Duty.of_run(run, "run"))
    for name in ("tension", "tension_rms", "speed", "longest", "shortest", "given", "taken"):
        assert getattr(asked, name) == pytest.approx(getattr(done, name), rel=0.01, abs=1.0), name


def test_skipped_commands_are_not_counted():
    robot, time = robot_of("caroca"), np.linspace(0.0, 1.0, 101)
    tension, feasible = np.full((101, robot.m), 100.0), np.ones(101, dtype=bool)
    tension[50], feasible[50] = 9e9, False
    found = demands(made(robot, tension, np.zeros((101, robot.m)), time, feasible=feasible))
    assert found.tension == pytest.approx(100.0)
    assert found.tension_rms == pytest.approx(100.0)
    nothing = sizing([made(robot, tension, np.zeros((101, robot.m)), time, feasible=np.zeros(101, dtype=bool))])
    assert nothing.to_dict()["cables"][0]["breaking_load_N"] is None
    assert nothing.to_dict()["duties"][0]["infeasible"] == 101


def test_the_worst_of_several(foreseen, run):
    both = sizing([foreseen, Duty.of_run(run, "run")], safety=4.0)
    parts = [demands(foreseen), demands(Duty.of_run(run, "run"))]
    assert both.worst.tension == pytest.approx(np.max([each.tension for each in parts], axis=0))
    assert both.worst.tension_least == pytest.approx(np.min([each.tension_least for each in parts], axis=0))
    assert both.worst.shortest == pytest.approx(np.min([each.shortest for each in parts], axis=0))
    row = both.to_dict()["cables"][3]
    assert row["breaking_load_N"] == pytest.approx(4.0 * row["tension_peak_N"])
    assert row["by"] == ("foreseen" if parts[0].tension[3] >= parts[1].tension[3] else "run")


@pytest.mark.slow
def test_with_one_cable_broken_the_others_hold(foreseen):
    parts = list(with_one_broken(foreseen))
    assert len(parts) == 8
    some = parts[4]
    assert np.isnan(some.tension[:, 4]).all()
    k = int(np.argmax(some.feasible))
    low, high = foreseen.robot.tension_min.copy(), foreseen.robot.tension_max.copy()
    low[4] = high[4] = 0.0
    alone = distribute(foreseen.robot, foreseen.poses[k], foreseen.wrenches[k], tension_min=low, tension_max=high)
    assert np.array_equal(np.delete(alone.tension, 4), np.delete(some.tension[k], 4))
    worst = sizing(parts).to_dict()
    assert not any(each["exceeded"] for each in worst["duties"])  # a broken cable's 0 N is below no limit


def test_broken_cables_carry_no_tension():
    """0 N is not a tension that it should have, and no limit is left by it."""
    scenario = cdpr.load_scenario("scenarios/cable_break.yaml")
    for duty in (Duty.of_scenario(scenario, "foreseen"), Duty.of_run(cdpr.simulate(scenario), "run")):
        lost = np.isnan(duty.tension)
        assert lost[-1].sum() == 1
        assert not lost[0].any()
        found = sizing([duty]).to_dict()
        assert not any("pull less" in text for text in found["duties"][0]["exceeded"])
        assert all(each["tension_least_N"] > 0.0 for each in found["cables"])


def test_each_corner_is_evaluated_over_the_workspace():
    robot = robot_of("caroca")
    where = region(robot, cells=3)
    duty = over_workspace(robot, where, box([50, 40, 30, 5, 5, 5]), GRAVITY)
    assert len(duty.tension) == where.cells * 64
    k = 64 * 5 + 17
    share = duty.wrenches[k] - duty.wrenches[64 * 5 : 64 * 6].mean(axis=0)
    assert np.abs(share) == pytest.approx([50, 40, 30, 5, 5, 5])
    assert duty.wrenches[64 * 5 : 64 * 6].mean(axis=0)[2] == pytest.approx(9.81 * robot.platform.mass)
    found = demands(duty)
    assert np.isfinite(found.tension).all()
    assert np.isnan(found.speed).all()
    with pytest.raises(CdprError, match="choose fewer cells"):
        over_workspace(robot, region(robot, cells=100), box([50, 40, 30, 5, 5, 5]), GRAVITY)
    with pytest.raises(CdprError, match="corners"):
        over_workspace(robot, where, ellipsoid([50, 50, 50, 5, 5, 5]), GRAVITY)


def test_exceeded_limits_are_reported():
    robot, time = robot_of("caroca"), np.linspace(0.0, 1.0, 11)
    found = sizing([made(robot, 2.0 * robot.tension_max, np.zeros((11, 8)), time)]).to_dict()
    assert "pull more than their highest tension" in found["duties"][0]["exceeded"][0]
    reached = sizing([made(robot, robot.tension_max, np.zeros((11, 8)), time)]).to_dict()
    assert reached["duties"][0]["exceeded"] == []


@pytest.mark.parametrize("safety", [0.5, float("nan"), float("inf")])
def test_a_safety_that_makes_no_sense(foreseen, safety):
    with pytest.raises(CdprError, match="safety"):
        sizing([foreseen], safety)


@pytest.mark.slow
def test_the_command(tmp_path):
    page = tmp_path / "sub" / "size.html"
    told = cli("size", "scenarios/winch.yaml", "--safety", "6", "--out", str(page))
    assert "drum" in told.stdout
    assert "motor" in told.stdout
    assert str(page) in told.stdout
    text = page.read_text()
    assert "Breaking load 6 times" in text
    assert "All duties are within" in text
    figures = json.loads(cli("size", "scenarios/caroca.yaml", "--broken", "--json").stdout)
    assert figures["duties"][0]["infeasible"] == 0
    assert len(figures["duties"]) == 9


@sampled(
    lambda words, code, message: message != "size them separately",
    ("words", "code", "message"),
    [
        (["scenarios/robots/caroca.yaml"], 2, "is a robot"),
        (["scenarios/caroca.yaml", "scenarios/ipanema_1.yaml"], 2, "size them separately"),
        (["scenarios/caroca.yaml", "--lower", "0,0,0"], 2, "--wrench-box"),
        (["scenarios/caroca.yaml", "--cells", "5"], 2, "--wrench-box"),
        (["scenarios/caroca.yaml", "--out", "size.txt"], 8, "ends in .html"),
        (["scenarios/caroca.yaml", "--safety", "0.2"], 2, "--safety"),
        (["."], 2, "contains no"),
    ],
)
def test_errors_are_reported(words, code, message):
    told = cli("size", *words)
    assert told.returncode == code
    assert message in told.stderr


def test_a_short_motion_in_a_long_run_is_followed_as_finely():
    """And a short push in it is met."""
    changes = {"trajectory.duration": 1.0}
    push = {"events": [{"type": "wrench", "time": 30.503, "duration": 0.005, "force": [0, 0, -1000]}]}
    brief = Duty.of_scenario(load_scenario(CAROCA, overrides=changes | {"simulation.duration": 2.0}), "brief")
    long = Duty.of_scenario(load_scenario(CAROCA, overrides=changes | {"simulation.duration": 600.0}), "long")
    pushed = Duty.of_scenario(load_scenario(CAROCA, overrides=changes | push | {"simulation.duration": 60.0}), "push")
    one, other, third = (demands(each) for each in (brief, long, pushed))
    for name in ("tension", "speed", "acceleration", "braking"):
        assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-3), name
    assert third.tension.max() > 1.2 * one.tension.max()


def test_turns_of_several_duties_are_from_the_shortest_to_the_longest_of_all():
    low = load_scenario(CAROCA, overrides={"trajectory.to.position": [1.0, 0.5, 1.2]})
    high = load_scenario(CAROCA, overrides={"trajectory.to.position": [-1.0, -0.5, 1.2]})
    several = sizing([Duty.of_scenario(low, "low"), Duty.of_scenario(high, "high")]).worst
    turns = drum_turns(low.robot, several.shortest, several.longest)
    assert np.array_equal(several.turns, turns, equal_nan=True)


def test_controllers_of_winches_have_other_tensions():
    """A note of `size` and `info`: their tensions are those of a solver, although the controller commands lengths."""
    said = []
    cdpr.size("camera_robot", overrides=SHORT, say=said.append)
    note = "those of the solver qp; controller 'inverse_kinematics' commands the winches without a solver, so a run has"
    assert any(text.startswith(f"tensions: {note} other tensions; size the run") for text in said)
    assert note in " ".join(cli("info", "camera_robot").stdout.split())
    cdpr.size("winch", overrides=SHORT, say=(said := []).append)
    assert not any(text.startswith("tensions") for text in said)
    assert "without a solver" not in cli("info", "winch").stdout


def test_motors_of_a_run_pull_beyond_the_friction_of_pulleys():
    """The command of a drum is its torque at rest, from the tension at the winch; figures of cables are unchanged."""
    changes = {"robot.cable.exit.friction": 0.2, "robot.cable.model": "rigid", "simulation.duration": 0.5}
    changes |= {"robot.winch": {"drum_radius": 0.05, "inertia": 0.02}}
    run = cdpr.simulate("scenarios/cogiro_pulleys.yaml", overrides=changes)
    duty = Duty.of_run(run, "run")
    assert np.abs(run.winch_tension - run.cable_tension).max() > 10.0
    found = demands(duty)
    still = np.gradient(duty.rate, duty.time, axis=0)
    drums = drum_motion(duty.robot, duty.length, duty.rate, still)
    assert found.torque == pytest.approx(np.abs(_torque(duty.robot, run.winch_tension, drums)).max(axis=0))
    assert found.tension == pytest.approx(run.cable_tension.max(axis=0))
    figures = sizing([duty]).to_dict()
    assert "motor torques of runs include it" in figures["friction"]
    assert "friction" not in sizing([Duty.of_scenario(cdpr.load_scenario("scenarios/winch.yaml"), "one")]).to_dict()


def test_commands_name_the_friction_that_they_omit(tmp_path):
    rubbing = ["--set", "cable.exit.friction=0.2"]
    robot = str(ROOT / "scenarios" / "robots" / "cogiro_pulleys.yaml")
    shown = [
        cli("equilibrium", robot, "--compensate", *rubbing),
        cli("workspace", "static", robot, "--cells", "2", "--out", str(tmp_path / "w.npz"), *rubbing),
        cli("size", "cogiro_pulleys", "--set", "robot.cable.exit.friction=0.2"),
    ]
    for each in shown:
        assert "friction on pulleys: " in each.stdout, each.stdout + each.stderr
    assert "friction" not in cli("equilibrium", robot, "--compensate").stdout


def test_an_empty_drum_is_an_error():
    growth = {"robot.winch.drum_growth": 0.005}
    empty = r"winch\.yaml: cable 'cable_1': its drum is empty at a length of 5\.76 m, .* winch\.drum_growth"
    with pytest.raises(CdprError, match=empty):
        cdpr.size([ROOT / "scenarios" / "winch.yaml"], overrides=growth)
