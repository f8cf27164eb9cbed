"""Imperfect drives: each imperfection against a replay of the commands in numpy, limits, restarts and messages."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from log_cases import same_bits
from plants import installed
from restarts import assert_restarts_give

import cdpr
from cdpr.mechanics.kinematics import wrench_matrix
from cdpr.simulation.drives import drives_of

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
PLANAR = str(ROOT / "scenarios" / "planar.yaml")
SHORT = {"simulation.duration": 0.05}
STEP = 0.001
CAMERA = str(ROOT / "scenarios" / "camera_robot.yaml")
SERVO = {"type": "position", "drum_radius": 0.05, "inertia": 0.002, "velocity_gain": 1.0, "position_gain": 50.0}


def replay(commands, step, rates=False, delay=0.0, resolution=0.0, rate_max=None, backlash=0.0):
    """Return the commands (K, m) that drives apply to `commands` (K, m)."""
    sent = resolution * (np.rint(commands / resolution) + 0.0) if resolution else commands  # no -0
    before = np.zeros_like(sent[0]) if rates else sent[0]
    late = round(delay / step)
    sent = np.concatenate([np.tile(before, (late, 1)), sent])[: len(sent)]
    motor, drum, applied = before, before, []
    play = np.zeros_like(before)
    for command in sent:
        if rate_max is not None:
            command = np.minimum(np.maximum(command, motor - step * rate_max), motor + step * rate_max)
        motor = command
        if not backlash:
            drum = motor
        elif rates:
            moved = play + step * motor
            play = np.clip(moved, -backlash / 2, backlash / 2)
            drum = (moved - play) / step
        else:
            drum = np.clip(drum, motor - backlash / 2, motor + backlash / 2)
        applied.append(drum)
    return np.array(applied)


TENSIONS = {
    "delay": {"delay": 0.01},
    "resolution": {"resolution": 5.0},
    "rate_max": {"rate_max": 50.0},
    "backlash": {"backlash": 4.0},
    "all": {"delay": 0.003, "resolution": 0.5, "rate_max": 2000.0, "backlash": 2.0},
}


@pytest.mark.parametrize("name", TENSIONS)
def test_commanded_tensions(name):
    """With ideal cables, the tension of each cable is the command that its drive applies."""
    run = cdpr.simulate(CAROCA, overrides={**SHORT, "drives": TENSIONS[name]})
    expected = replay(run.tension, STEP, **TENSIONS[name])
    assert same_bits(run["drive_command"], expected)
    assert same_bits(run.cable_tension, expected)
    assert not np.array_equal(expected, run.tension)


LENGTHS = {
    "delay": {"delay": 0.02},
    "resolution": {"resolution": 0.001},
    "rate_max": {"rate_max": 0.05},
    "backlash": {"backlash": 0.004},
    "all": {"delay": 0.006, "resolution": 0.0001, "rate_max": 0.3, "backlash": 0.002},
}


def camera(winch, drives, **changes):
    kinds = {"robot.winch": winch, "simulation.duration": 0.4, "simulation.control_step": 0.002}
    steps = {"simulation.physics_step": 0.001, "simulation.backend": "reference"}
    return cdpr.load_scenario(CAMERA, overrides={**kinds, **steps, "drives": drives, **changes})


@pytest.mark.parametrize(
    "winch", [{"type": "position"}, {"type": "velocity"}, SERVO], ids=["position", "rate", "servo"]
)
@pytest.mark.parametrize("name", LENGTHS)
def test_commanded_lengths_and_rates(name, winch):
    rates = winch["type"] == "velocity"
    run = cdpr.simulate(camera(winch, LENGTHS[name]))
    expected = replay(run["winch_command"], 0.002, rates, **LENGTHS[name])
    assert same_bits(run["drive_command"], expected)
    assert not np.array_equal(expected, run["winch_command"])
    wound = run["unstretched_length"]
    if winch == {"type": "position"}:  # an ideal winch holds the length at the end of the period
        np.testing.assert_allclose(wound[1:], expected[:-1], rtol=0.0, atol=1e-12)
    elif rates:
        np.testing.assert_allclose(np.diff(wound, axis=0), 0.002 * expected[:-1], rtol=0.0, atol=1e-12)


def test_a_reversed_rate_acts_after_the_play():
    """Closed form: at a constant rate, the drum lags by half the play; after the reversal by all of it."""
    rate, play = 0.25, 0.01

    class Reversing(cdpr.plugins.Controller):
        output = "rate"

        def control(self, time, state, desired, out):
            out[:] = rate if time < 0.1 - 1e-9 else -rate

    scenario = camera({"type": "velocity"}, {"backlash": play})
    run = cdpr.simulate(scenario, controller=Reversing)
    wound = run["unstretched_length"] - run["unstretched_length"][0]
    np.testing.assert_allclose(wound[50], rate * 0.1 - play / 2, atol=1e-12)
    np.testing.assert_allclose(wound[50 + 20], wound[50], atol=1e-12)  # 0.01 m in 20 periods
    np.testing.assert_allclose(wound[-1], wound[50] - (rate * 0.3 - play), atol=1e-12)


def test_ideal_drives_are_no_part_of_the_loop():
    plain = cdpr.simulate(CAROCA, overrides=SHORT)
    for drives in ({}, {"delay": 0, "resolution": 0, "backlash": 0, "cables": {"cable_1": {"delay": 0.0}}}):
        scenario = cdpr.load_scenario(CAROCA, overrides={**SHORT, "drives": drives})
        assert drives_of(scenario) is None
        assert same_bits(cdpr.simulate(scenario).rows, plain.rows)


def test_very_small_imperfections_change_next_to_nothing():
    plain = cdpr.simulate(CAROCA, overrides=SHORT)
    run = cdpr.simulate(CAROCA, overrides={**SHORT, "drives": {"resolution": 1e-9, "rate_max": 1e9, "backlash": 1e-9}})
    assert np.abs(run.position - plain.position).max() < 1e-12
    assert np.abs(run["drive_command"] - run.tension).max() < 2e-9


def test_single_cables():
    own = {"delay": 0.002, "cables": {"cable_2": {"delay": 0.0, "resolution": 1.0}, "cable_5": {"delay": 0.01}}}
    run = cdpr.simulate(CAROCA, overrides={**SHORT, "drives": own})
    for i in range(8):
        about = {1: {"resolution": 1.0}, 4: {"delay": 0.01}}.get(i, {"delay": 0.002})
        assert same_bits(run["drive_command"][:, i], replay(run.tension[:, i : i + 1], STEP, **about)[:, 0])


def test_late_tensions_pull_the_platform_off_its_path():
    """The error is of the first order in the delay."""
    changes = {"simulation.duration": 1.5}
    plain = cdpr.simulate(CAROCA, overrides=changes)
    found = []
    for delay in (0.0, 0.005, 0.01):
        run = cdpr.simulate(CAROCA, overrides={**changes, "drives": {"delay": delay}})
        found.append(np.linalg.norm(run.position - plain.position, axis=1).max())
    assert found[0] == 0.0
    assert found[2] / found[1] == pytest.approx(2.0, rel=0.2)


def test_energy_is_balanced():
    run = cdpr.simulate(CAROCA, overrides={"simulation.duration": 0.5, "drives": TENSIONS["all"]})
    assert run.cable_work.max() > 10.0
    assert np.abs(run.energy_residual).max() < 1e-9


@pytest.mark.parametrize("backend", installed("mujoco", "bullet", "dart"))
def test_engines_agree_with_the_reference(backend):
    changes = {**SHORT, "drives": TENSIONS["all"], "backend_options.reference.scheme": "semi_implicit_euler"}
    ours, theirs = (cdpr.simulate(CAROCA, backend=each, overrides=changes) for each in ("reference", backend))
    assert np.abs(ours.position - theirs.position).max() < 1e-11
    assert np.abs(ours.cable_work - theirs.cable_work).max() < 1e-9


@pytest.mark.parametrize("scenario", [CAROCA, CAMERA])
def test_restarts_and_rollouts_repeat_the_run(scenario):
    drives = TENSIONS["all"] if scenario == CAROCA else LENGTHS["all"]
    step = cdpr.load_scenario(scenario).simulation.control_step
    changes = {"simulation.duration": 50 * step, "drives": drives | {"delay": 7 * step}}
    run = cdpr.simulate(scenario, overrides=changes)
    assert_restarts_give(run.rows.tobytes(), scenario, changes)
    delays = [0.0, 3 * step, 7 * step, 7 * step]
    own = cdpr.load_scenario(scenario, overrides=changes)
    batch = cdpr.rollout(own, 4, vary={"drives.delay": delays}, columns=["position", "drive_command"], threads=1)
    assert same_bits(batch["drive_command"][3], run["drive_command"])
    assert same_bits(batch["position"][2], run.position)
    one = cdpr.simulate(own, overrides={"drives.delay": delays[1]})
    assert same_bits(batch["position"][1], one.position)


def test_commands_from_outside_pass_the_drives():
    changes = {**SHORT, "drives": {"delay": 0.005}}
    with cdpr.Simulation(CAROCA, overrides=changes) as simulation:
        simulation.step(10)
        for k in range(10):
            simulation.step(tension=np.full(8, 200.0 + k))
        run = simulation.run()
    assert same_bits(run["drive_command"][:20], replay(run.tension[:20], STEP, delay=0.005))
    assert run["drive_command"][19, 0] == 204.0


def test_faults_of_cables_act_at_once():
    faults = [
        {"type": "cable_jam", "time": 0.02, "cable": "cable_1"},
        {"type": "cable_break", "time": 0.03, "cable": 2},
    ]
    run = cdpr.simulate(CAROCA, overrides={**SHORT, "events": faults, "drives": {"delay": 0.005}})
    assert (run.cable_tension[20:, 0] == run.cable_tension[19, 0]).all()
    assert (run.cable_tension[30:, 1] == 0.0).all()
    assert run.cable_tension[29, 1] > 0.0
    assert same_bits(run["drive_command"][:, 2:], replay(run.tension[:, 2:], STEP, delay=0.005))


def test_a_power_cut_acts_at_once():
    stop = [{"type": "emergency_stop", "time": 0.02, "category": 0}]
    run = cdpr.simulate(CAROCA, overrides={**SHORT, "events": stop, "drives": {"delay": 0.005, "rate_max": 10.0}})
    assert not run.cable_tension[20:].any()
    assert run.cable_tension[19].all()


def test_true_wrench_of_the_applied_tensions():
    changes = {**SHORT, "drives": {"resolution": 20.0}, "believed": {"platform": {"mass": 150.0}}}
    run = cdpr.simulate(CAROCA, overrides=changes)
    robot = cdpr.load_scenario(CAROCA).robot
    for k in (0, 30):
        matrix = wrench_matrix(robot, np.concatenate([run.position[k], run.orientation[k], np.zeros(6)]))
        np.testing.assert_allclose(run["true_wrench"][k], matrix @ run["drive_command"][k], rtol=1e-12, atol=1e-9)


def test_a_log_and_a_saved_scenario(tmp_path):
    scenario = cdpr.load_scenario(CAROCA, overrides={**SHORT, "drives": TENSIONS["all"]})
    run = cdpr.simulate(scenario, out=tmp_path / "run")
    read = cdpr.load_run(tmp_path / "run")
    assert same_bits(read.rows, run.rows)
    scenario.save(tmp_path / "saved.yaml")
    assert same_bits(cdpr.simulate(tmp_path / "saved.yaml").rows, run.rows)


MESSAGES = {
    "multiple": (
        {"delay": 0.0015},
        "drives.delay: must be an integer multiple of control_step, 0.001 (s), got 0.0015; nearest: 0.001 or 0.002",
    ),
    "own": ({"cables": {"cable_2": {"delay": 0.0004}}}, "drives.cables.cable_2.delay: must be an integer multiple"),
    "name": ({"cables": {"cable_9": {"delay": 0.001}}}, "unknown cable 'cable_9': expected one of cable_1, cable_2"),
    "negative": ({"resolution": -1.0}, "drives.resolution"),
    "rate": ({"rate_max": 0.0}, "drives.rate_max"),
    "long": ({"delay": 1.5}, "drives.delay"),
    "key": ({"lag": 1.0}, "drives.lag"),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_messages(name):
    drives, text = MESSAGES[name]
    with pytest.raises(cdpr.CdprError) as caught:
        cdpr.load_scenario(CAROCA, overrides={"drives": drives})
    assert text in str(caught.value)


@pytest.mark.parametrize("use", ["plant_fmu", "controller_fmu"])
def test_exported_plants_reject_them(use):
    from cdpr.simulation.needs import omitted, require

    scenario = cdpr.load_scenario(CAROCA, overrides={"drives": {"delay": 0.001}})
    with pytest.raises(cdpr.CdprError, match="drives: not supported by an exported FMU"):
        require(scenario, use)
    assert [each for each in omitted(scenario, "mjcf") if each.startswith("drives")]
    require(scenario, "bare_controller_fmu")
    require(scenario, "native")


@pytest.mark.parametrize("winch", [{"type": "position"}, SERVO], ids=["position", "servo"])
def test_lengths_that_no_cable_can_have_end_the_run(winch):
    class Reeling(cdpr.plugins.Controller):
        output = "length"

        def control(self, time, state, desired, out):
            out[:] = 3.4
            out[1] -= 0.0 if time < 0.1 - 1e-9 else 3.5

    scenario = camera(winch, {})
    said = r"^t = 0.1 s: cable 'cable_2': a length of -0.1 m is commanded: expected more than 0 and at most 1e\+09 m"
    with pytest.raises(cdpr.Diverged, match=said):
        cdpr.simulate(scenario, controller=Reeling)
    said = r"^t = 0 s: cable 'cable_1': its unwound length is 0 m, expected more than 0: .* resolution"
    with pytest.raises(cdpr.Diverged, match=said):
        cdpr.simulate(camera(winch, {"resolution": 1e3}))


def test_a_resolution_below_that_of_numbers_changes_nothing():
    finest = 5e-324  # m, the smallest number
    fine, exact = (
        cdpr.simulate(camera({"type": "position"}, drives))
        for drives in ({"resolution": finest}, {"resolution": 0.0, "delay": 0.0})
    )
    assert same_bits(fine.position, exact.position)
    assert same_bits(fine["drive_command"], fine["winch_command"])
