"""Runs with steppers: whole steps, lost steps of overloaded motors against closed forms, limits, uses and messages."""

from __future__ import annotations

import numpy as np
import pytest
from log_cases import same_bits
from plants import installed

import cdpr
from cdpr.analysis.distribution.describe import describe_robot, winch_figures
from cdpr.simulation.linearised import linearise
from cdpr.simulation.poles import closed_loop, poles, verdict
from cdpr.ui.report.text.description import _winches

RADIUS, TURN, STALL, STIFFNESS = 0.05, 200.0, 2.0, 2e4  # m, full steps, N m, N
PERIOD = 4.0 * 2.0 * np.pi / TURN * RADIUS  # m of cable in four full steps
STEPPER = {"type": "stepper", "drum_radius": RADIUS, "steps_per_turn": TURN, "microsteps": 16, "stall_torque": STALL}
STRONG = STEPPER | {"stall_torque": 5.0}  # N m: holds the camera
MOTOR = STEPPER | {"inertia": 2e-4, "viscous_friction": 0.05}
ANCHORS = np.array([[-2.0, -2.0, 3.0], [2.0, -2.0, 3.0], [2.0, 2.0, 3.0], [-2.0, 2.0, 3.0]])


def camera(winch, **changes):
    """Return a platform on four lines that moves 0.5 m."""
    data = {
        "robot": {
            "dof": ["x", "y", "z"],
            "platform": {"mass": 5.0},
            "tension": {"min": 0, "max": 400},
            "home": {"position": [0.0, 0.0, 1.0]},
            "cable": {"model": "elastic", "axial_stiffness": STIFFNESS, "damping": 100.0},
            "winch": winch,
            "cables": [{"frame": A.tolist(), "platform": [0, 0, 0]} for A in ANCHORS],
        },
        "simulation": {"backend": "reference", "duration": 1.0, "control_step": 0.002, "physics_step": 0.0005},
        "trajectory": {"type": "quintic", "duration": 0.8, "to": {"position": [0.3, 0.2, 1.3]}},
        "controller": {"type": "inverse_kinematics", "pretension": 15.0},
    }
    return cdpr.load_scenario(data, overrides=changes)


def tug(winch, **changes):
    """Return a slide between a stepper on the left and an ideal drive on the right, 4 m apart."""
    data = {
        "robot": {
            "dof": ["x"],
            "platform": {"mass": 0.5},
            "tension": {"min": 0, "max": 1000},
            "home": {"position": [0.0, 0.0, 0.0]},
            "cable": {"model": "elastic", "axial_stiffness": STIFFNESS, "damping": 60.0},
            "cables": [
                {"name": "left", "frame": [-2.0, 0.0, 0.0], "platform": [0, 0, 0], "winch": winch},
                {"name": "right", "frame": [2.0, 0.0, 0.0], "platform": [0, 0, 0], "winch": {"type": "position"}},
            ],
        },
        "simulation": {"backend": "reference", "duration": 1.0, "control_step": 0.001, "physics_step": 0.0005},
        "trajectory": {"type": "hold"},
        "controller": {"type": "inverse_kinematics"},
    }
    return cdpr.load_scenario(data, overrides=changes)


class Tug(cdpr.plugins.Controller):
    """Hold the left cable, wind in the right one by `distance` (m) in 0.8 s, and then unwind it again if `back`."""

    output = "length"
    distance, back = 0.02, False

    def control(self, time, state, desired, out):
        share = min(time / 0.8, 1.0)
        share -= max(min((time - 0.9) / 0.8, 1.0), 0.0) if self.back else 0.0
        out[:] = 2.0, 2.0 - self.distance * share


def tugging(distance, back=False):
    return type("Tugging", (Tug,), {"distance": distance, "back": back})


def losses(distance, rotor=False):
    """Return how often the stepper slips: until its torque can hold the cables, E A (D - L) / L r, at some deflection.

    The rotor deflects by up to two full steps, the drum without inertia by nothing.
    """
    deflection = np.linspace(0.0, PERIOD / 2.0, 10001)  # m
    torque = STALL * np.sin(2.0 * np.pi * deflection / PERIOD)
    n = 0
    while True:
        unwound = 4.0 - distance + n * PERIOD + (deflection if rotor else 0.0)
        load = np.asarray((4.0 - unwound) / unwound * STIFFNESS * RADIUS)
        if (load <= (torque if rotor else STALL)).any():
            return n
        n += 1


@pytest.mark.parametrize("winch", [STRONG, MOTOR | STRONG], ids=["ideal", "rotor"])
def test_a_motor_below_its_stall_torque_holds_whole_steps(winch):
    run = cdpr.simulate(camera(winch))
    assert run.motor_torque.max() < 5.0
    assert not run.lost_steps.any()
    assert run.summary()["lost_steps"] == 0
    microstep = PERIOD / 4.0 / 16.0
    steps = run.counted_length / microstep
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    np.testing.assert_allclose(run.counted_length[1:], run.winch_command[:-1], atol=0.5001 * microstep)
    lag = 0.0 if winch is STRONG else PERIOD / 4.0
    np.testing.assert_allclose(run["unstretched_length"], run.counted_length, atol=lag + 1e-9)
    if winch is STRONG:
        np.testing.assert_allclose(run.motor_torque, RADIUS * run.cable_tension, rtol=0.1)


@pytest.mark.parametrize("winch", [STEPPER, MOTOR], ids=["ideal", "rotor"])
@pytest.mark.parametrize("distance", [0.0075, 0.009, 0.03])
def test_an_overloaded_motor_loses_steps(winch, distance):
    """Two cables in a line have one tension, E A (D - L) / L."""
    run = cdpr.simulate(tug(winch), controller=tugging(distance))
    expected = losses(distance, rotor=winch is MOTOR)
    assert run.lost_steps[-1, 0] == 4 * expected
    assert np.isnan(run.lost_steps[:, 1]).all()
    slipped = run["unstretched_length"][-1, 0] - run.counted_length[-1, 0]
    lag = PERIOD / 4.0 if winch is MOTOR else 1e-9
    assert slipped == pytest.approx(expected * PERIOD, abs=lag)
    found = [event for event in run.events if event.kind == "lost_steps"]
    assert len(found) == len(run.summary()["lost_steps_intervals"])
    assert sum(one["steps"] for one in run.summary()["lost_steps_intervals"]) == run.summary()["lost_steps"]
    if expected:
        assert found[0].cable == "left"
        assert "the stepper of cable 'left' loses 4 full steps: its cable is paid out" in found[0].text
    assert run.summary()["energy_J"]["balanced"]


def test_the_drive_does_not_notice():
    """After the load is gone, the cable is too long by the lost steps: it is slack at its commanded length."""
    run = cdpr.simulate(tug(STEPPER), controller=tugging(0.02, back=True), overrides={"simulation.duration": 2.0})
    assert run.lost_steps[-1, 0] == 4 * losses(0.02) > 0
    np.testing.assert_allclose(run.counted_length[-1, 0], 2.0, atol=PERIOD / 128.0)
    too_long = run["unstretched_length"][-1].sum() - 4.0
    assert too_long == pytest.approx(losses(0.02) * PERIOD, abs=PERIOD / 64.0)
    assert run.summary()["slack_samples"] > 0


def test_the_limit_of_small_steps_is_the_ideal_drive():
    ideal = cdpr.simulate(camera({"type": "position"}))
    apart = []
    for microsteps in (16, 64, 256, 1e9):
        run = cdpr.simulate(camera(STRONG | {"microsteps": microsteps}))
        apart.append(np.abs(run.position - ideal.position).max())
    assert apart[-1] < 1e-9
    assert (np.diff(apart) < 0.0).all(), apart
    assert apart[2] < PERIOD / 4.0 / 256.0


def test_a_stiff_rotor_approaches_the_stepper_without_inertia():
    """Its deflection under load is a r / (pi/2) asin(r T / M_s)."""
    run = cdpr.simulate(camera(MOTOR | {"stall_torque": 50.0}, **{"simulation.physics_step": 0.0001}))
    ideal = cdpr.simulate(camera(STEPPER | {"stall_torque": 50.0}, **{"simulation.physics_step": 0.0001}))
    load = RADIUS * ideal.cable_tension[[0, -1]]
    lag = PERIOD / (2.0 * np.pi) * np.arcsin(load / 50.0)
    found = run["unstretched_length"][-1] - run.counted_length[-1]
    np.testing.assert_allclose(found, lag[1] - lag[0], atol=2e-6)


def test_the_speed_of_the_steps_is_limited():
    free = cdpr.simulate(camera(STRONG))
    slow = cdpr.simulate(camera(STRONG | {"speed_max": 2.0}, **{"simulation.duration": 6.0}))
    assert np.abs(free["unstretched_rate"]).max() > 0.11
    assert np.abs(slow["unstretched_rate"]).max() < 0.1 + 1e-9
    assert np.abs(slow.counted_length[-1] - free.counted_length[-1]).max() < 1e-12


@pytest.mark.parametrize("winch", [STEPPER, MOTOR], ids=["ideal", "rotor"])
def test_snapshots_rollouts_and_files_repeat_the_run(winch, tmp_path):
    """While the motors lose steps."""
    scenario = camera(winch | {"stall_torque": 0.5}, **{"simulation.duration": 0.4})
    run = cdpr.simulate(scenario)
    assert run.lost_steps.any()
    with cdpr.Simulation(scenario) as simulation:
        simulation.step(60)
        middle = simulation.snapshot()
        simulation.step(50)
        simulation.restore(middle)
        simulation.step(50)
        again = simulation.state[:3].copy()
    assert same_bits(again, run.position[110])
    found = cdpr.rollout(scenario, 2, vary={"robot.platform.mass": [5.0, 6.0]}, columns=["position"], threads=1)
    assert same_bits(found["position"][0], run.position[::2])
    scenario.save(tmp_path / "saved.yaml")
    again = cdpr.simulate(tmp_path / "saved.yaml", out=tmp_path / "run")
    assert same_bits(again.position, run.position)
    assert cdpr.load_run(tmp_path / "run").summary()["lost_steps"] == run.summary()["lost_steps"]


@pytest.mark.parametrize("backend", installed("mujoco", "bullet", "dart"))
@pytest.mark.parametrize("winch", [STEPPER, MOTOR], ids=["ideal", "rotor"])
def test_engines_agree_with_the_reference(backend, winch):
    about = {"simulation.duration": 0.5, "backend_options.reference.scheme": "semi_implicit_euler"}
    ours, theirs = (cdpr.simulate(camera(winch, **about), backend=each) for each in ("reference", backend))
    assert np.abs(ours.position - theirs.position).max() < 1e-11


@pytest.mark.parametrize("controller", ["computed_torque", "cable_length"])
def test_controllers_of_wrenches_and_tensions_drive_steppers_by_the_map(controller):
    gains = {"kp": 3000.0, "kd": 300.0} if controller == "cable_length" else {"kp": 40.0, "kd": 12.0}
    changes = {"controller": {"type": controller, **gains}, "robot.cable.damping": 5.0}
    run, ideal = (
        cdpr.simulate(camera(each, **changes)) for each in (STRONG | {"microsteps": 256}, {"type": "position"})
    )
    assert np.abs(run.position - ideal.position).max() < 5e-4


GEARED = {"gear_ratio": 3.0, "drum_growth": 2e-4, "lines": 2.0, "reeving": 2.0}


def angle_of(lengths, home):
    """Return the angle of a drum in closed form, rad: its squared radius grows by n g per length of line wound."""
    growth, falls = GEARED["drum_growth"] * GEARED["lines"], GEARED["reeving"]
    wound = falls * (home - lengths)
    return 2.0 * (np.sqrt(RADIUS**2 + growth * wound) - RADIUS) / growth


@pytest.mark.parametrize("winch", [STRONG, MOTOR | STRONG], ids=["ideal", "rotor"])
def test_gears_layers_and_tackles_set_the_size_of_a_step(winch):
    """The drum turns by whole microsteps of the motor from its home pose, also while its radius grows."""
    scenario = camera(winch | GEARED, **{"simulation.physics_step": 0.0002})
    run = cdpr.simulate(scenario)
    assert not run.lost_steps.any()
    home = np.linalg.norm(ANCHORS - [0.0, 0.0, 1.0], axis=1)
    angle, microstep = angle_of(run.counted_length, home), 2.0 * np.pi / (TURN * GEARED["gear_ratio"] * 16.0)
    np.testing.assert_allclose(angle / microstep, np.round(angle / microstep), atol=1e-5)
    assert np.ptp(angle, axis=0).min() > 1.0
    commanded = angle_of(run.winch_command, home)
    np.testing.assert_allclose(angle[1:], commanded[:-1], atol=0.5001 * microstep)
    lag = 1e-9 if winch is STRONG else 16.0 * microstep
    np.testing.assert_allclose(run.drum_angle, angle, atol=lag)


@pytest.mark.parametrize("winch", [STEPPER, MOTOR], ids=["ideal", "rotor"])
def test_lost_steps_are_counted_on_a_drum_that_grows(winch):
    scenario = camera(winch | GEARED | {"stall_torque": 0.3}, **{"simulation.physics_step": 0.0002})
    run = cdpr.simulate(scenario)
    lost = run.lost_steps[-1]
    assert lost.max() > 40.0
    assert not (lost % 4.0).any()
    home = np.linalg.norm(ANCHORS - [0.0, 0.0, 1.0], axis=1)
    behind = angle_of(run.counted_length[-1], home) - run.drum_angle[-1]
    full_step = 2.0 * np.pi / (TURN * GEARED["gear_ratio"])
    # without inertia, a step that is lost at a sample slips in the following period
    np.testing.assert_allclose(behind / full_step, lost, atol=2.0 if winch is MOTOR else 4.0 + 1e-6)
    if winch is STEPPER:
        before = run.lost_steps[-2]
        np.testing.assert_allclose(behind / full_step, before, atol=1e-4)


def test_losses_of_the_gear_load_the_motor():
    """While the drum winds in, the motor needs r T / e."""
    run = cdpr.simulate(camera(STRONG | {"stall_torque": 50.0, "efficiency": 0.5, "coulomb_speed": 1e-3}))
    winding = run.drum_speed > 0.1
    assert winding.any()
    np.testing.assert_allclose(run.motor_torque[winding], RADIUS * run.cable_tension[winding] / 0.5, rtol=1e-9)
    unwinding = run.drum_speed < -0.1
    np.testing.assert_allclose(run.motor_torque[unwinding], RADIUS * run.cable_tension[unwinding] * 0.5, rtol=1e-9)


def test_the_speed_limit_holds_on_a_drum_that_grows():
    slow = cdpr.simulate(camera(STRONG | GEARED | {"speed_max": 8.0}, **{"simulation.duration": 4.0}))
    assert 7.9 < np.abs(slow.drum_speed).max() < 8.0 * 1.001
    free = cdpr.simulate(camera(STRONG | GEARED))
    assert np.abs(slow.counted_length[-1] - free.counted_length[-1]).max() < 1e-12


MESSAGES = {
    "torque": ({"stall_torque": None}, "with winch.type stepper needs the stall torque (N m) of each cable"),
    "drum": ({"drum_radius": None}, "with winch.type stepper needs the radius of the drum"),
    "microsteps": ({"microsteps": 0.3}, "robot.winch.microsteps: must be at least 1, got 0.3"),
    "steps": ({"steps_per_turn": 1e-300}, "robot.winch.steps_per_turn: must be at least 1, got 1e-300"),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_messages(name):
    changes, text = MESSAGES[name]
    winch = {key: value for key, value in (STEPPER | changes).items() if value is not None}
    with pytest.raises(cdpr.CdprError) as caught:
        camera(winch)
    assert text in str(caught.value)


ONE_STEP = {"steps_per_turn": 1, "microsteps": 1, "drum_radius": 1.2}


def test_steps_that_are_large_for_the_cable():
    """2 pi 1.2 m is more than twice the cable, so that no step is the nearest number; with a gear the step is small."""
    large = camera(STEPPER | ONE_STEP)
    (text,) = (str(each) for each in large.warnings if "one step" in str(each))
    assert "robot.winch.steps_per_turn: one step of cable 'cable_1' is 7.54 m, and the cable 3.464 m long" in text
    with pytest.raises(cdpr.Diverged, match=r"'cable_1': its unwound length is 0 m, .* steps of its drive"):
        cdpr.simulate(large)
    assert not any("one step" in str(each) for each in camera(STEPPER | ONE_STEP | {"gear_ratio": 250}).warnings)


def test_the_description_of_a_robot_has_the_steps():
    robot = camera(MOTOR).robot
    (line,) = _winches(describe_robot(robot)["cables"])
    assert "0.0002 kg m^2 at the drum, 200 steps per turn, 16 microsteps, stall torque 2 N m; all cables" in line
    assert "microsteps" not in winch_figures(camera({"type": "position"}).robot.cables[0])


def test_unused_numbers_are_reported():
    assert camera(STEPPER | {"velocity_gain": 1.0}).unused == ("robot.winch.velocity_gain",)


def test_the_nominal_winch_is_merged_key_by_key():
    """Its type alone changes nothing else."""
    scenario = camera({"type": "position", "drum_radius": RADIUS}, believed={"winch": STEPPER})
    assert scenario.nominal.cables[0].winch.own["stall_torque"] == STALL
    torque = {"drum_radius": RADIUS, "inertia": 0.002}
    control = {"controller": {"type": "computed_torque"}}
    same = camera(torque, believed={"winch": {"type": "torque", "viscous_friction": 0.1}}, **control)
    winch = same.nominal.cables[0].winch
    assert (winch.drum_radius, winch.inertia, winch.viscous_friction) == (RADIUS, 0.002, 0.1)


def test_poles_of_steppers_without_inertia_are_those_of_ideal_drives():
    pose = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    control = {"controller": {"type": "computed_torque", "kp": 40.0, "kd": 12.0}}
    found, ideal = (
        closed_loop(camera(winch, **control), pose)
        for winch in (STRONG | GEARED, {"type": "position", "drum_radius": RADIUS} | GEARED)
    )
    assert found["poles"] == ideal["poles"]
    assert len(found["poles"]) > 6
    assert "very small steps" in found["notes"][0]
    assert not ideal["notes"]


def test_poles_of_a_rotor_are_those_of_its_linear_equations():
    """A slide on a rotor and an ideal drive, linear about the deflection at which the rotor holds the load."""
    damping, inertia, friction, mass = 60.0, 2e-4, 0.05, 0.5
    winch = MOTOR | {"microsteps": 1e9, "gear_ratio": 2.0}
    pull = {"controller": {"type": "inverse_kinematics", "pretension": 20.0}}
    run = cdpr.simulate(tug(winch, **pull))
    x, (own, other) = run.position[-1, 0], run["unstretched_length"][-1]
    angle = 2.0 * np.pi / (TURN * 2.0)  # rad, of a full step
    deflection = np.arcsin(run.motor_torque[-1, 0] / STALL)
    slope = STALL * 0.5 * np.pi / (RADIUS * angle) * np.cos(deflection)  # N m per m
    assert 0.3 < deflection < 0.9
    # states: x, unwound length of the left cable, and their rates
    stretch, unwind, right = STIFFNESS / own, -STIFFNESS * (2.0 + x) / own**2, STIFFNESS / other
    A = np.zeros((4, 4))
    A[:2, 2:] = np.eye(2)
    tension = np.array([stretch, unwind, damping, -damping])  # of the left cable
    A[2] = (-tension - [right, 0.0, damping, 0.0]) / mass
    A[3] = (RADIUS * RADIUS * tension - [0.0, RADIUS * slope, 0.0, friction]) / inertia
    expected = sorted(np.linalg.eigvals(A), key=lambda s: (s.real, s.imag))
    pose = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    loop = linearise(tug(winch, **pull, **{"simulation.physics_step": 0.0001}), pose)
    found = sorted((pole.value for pole in poles(loop)), key=lambda s: (s.real, s.imag))
    np.testing.assert_allclose(found, expected, rtol=1e-4)  # of the fourth-order scheme and the state at rest
    assert verdict(loop) == "stable"


def test_an_overloaded_stepper_has_no_poles():
    pose = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    found = closed_loop(camera(MOTOR | {"stall_torque": 0.2}), pose)
    assert found["poles"] is None
    assert "no state of rest" in found["problem"]


def test_exports_for_real_time_programs_leave_the_steps_to_the_drives(tmp_path):
    """Their program commands the lengths of an ideal drive."""
    files = []
    for name, winch in (("stepper", STEPPER), ("ideal", {"type": "position", "drum_radius": RADIUS})):
        cdpr.export(camera(winch), "native", out=tmp_path / name)
        files.append({path.name for path in (tmp_path / name).iterdir()})
    assert files[0] == files[1] != set()
