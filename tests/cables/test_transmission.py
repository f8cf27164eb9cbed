"""Gear, drum with layers and block and tackle against closed forms, energy balances and equivalent robots."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from log_cases import same_bits
from plants import installed

import cdpr
from cdpr.base.errors import CdprError, ScenarioError, SimulationStopped
from cdpr.cables.drums import drum_motion, unwound_lengths
from cdpr.cables.tables import home_lengths
from cdpr.model.cable import Winch

ANCHORS = np.array([[-2.0, -2.0, 3.0], [2.0, -2.0, 3.0], [2.0, 2.0, 3.0], [-2.0, 2.0, 3.0]])
HOME = np.array([0.0, 0.0, 1.0])
GOAL = [0.6, 0.4, 1.6]
RADIUS, INERTIA, VISCOUS = 0.03, 0.002, 0.02
DRUM = {"drum_radius": RADIUS, "inertia": INERTIA, "viscous_friction": VISCOUS}
GROWN = {"drum_growth": 5e-5, "lines": 2, "reeving": 3}


def camera(model="elastic", winch=DRUM, **changes):
    """Return a platform on four lines that moves to GOAL in 1 s."""
    data = {
        "robot": {
            "name": "camera",
            "dof": ["x", "y", "z"],
            "platform": {"mass": 10.0},
            "tension": {"min": 0, "max": 400},
            "home": {"position": HOME.tolist()},
            "cable": {"model": model, "axial_stiffness": 2e4, "damping": 150.0},
            "winch": winch,
            "cables": [{"frame": A.tolist(), "platform": [0, 0, 0]} for A in ANCHORS],
        },
        "simulation": {"backend": "reference", "duration": 1.2, "control_step": 0.002, "physics_step": 0.001},
        "trajectory": {"type": "quintic", "duration": 1.0, "to": {"position": GOAL}},
        "controller": {"type": "computed_torque", "kp": 40.0, "kd": 12.0},
    }
    if model == "rigid":
        del data["robot"]["cable"]["axial_stiffness"], data["robot"]["cable"]["damping"]
    return cdpr.load_scenario(data, overrides=changes)


def equal(one, other):
    """Return True if the columns of winches have the same bits in two runs."""
    names = "position", "tension", "cable_tension", "drum_angle", "drum_speed", "motor_torque", "motor_power"
    return all(same_bits(one[name], other[name]) for name in names)


def robot_with(**winch):
    return camera(winch=DRUM | winch).robot


def test_the_length_after_n_turns_is_that_of_a_spiral_of_layers():
    """Each turn at angle a winds r da, and the area of the layers is that of the cable: pi (r^2 - r_0^2) b = A n s."""
    robot, (g, n, k), steps = robot_with(**GROWN), GROWN.values(), 5000
    for turns in (-10.0, 1.0, 40.0):
        h, r, wound = 2.0 * np.pi * turns / steps, RADIUS, 0.0  # midpoint rule, layer by layer
        for _ in range(steps):
            wound += h * np.sqrt(RADIUS**2 + g * n * (wound + 0.5 * h * r))
            r = np.sqrt(RADIUS**2 + g * n * wound)
        length = unwound_lengths(robot, np.full((1, 4), 2.0 * np.pi * turns))[0]
        np.testing.assert_allclose(home_lengths(robot) - length, wound / k, rtol=1e-8)


def test_angles_are_the_motor_positions_of_reprapfirmware():
    """HangprinterKinematics: k0 (sqrt(R^2 + p k2) - R) steps, in mm, for a line that is p longer than at the origin."""
    Q, R, lines, advantage, steps = 0.0078, 75.0, 1, 2, 200 * 16 * 255 / 20
    robot = robot_with(drum_radius=1e-3 * R, drum_growth=1e-3 * Q, lines=lines, reeving=advantage)
    position = np.linspace(-900.0, 2000.0, 5)
    k2 = -advantage * lines * Q
    k0 = 2.0 * (advantage * steps / (2.0 * np.pi)) / k2
    motor = k0 * (np.sqrt(R**2 + position * k2) - R)
    unwound = home_lengths(robot) + 1e-3 * position[:, None]
    found = drum_motion(robot, unwound, 0.0 * unwound, 0.0 * unwound)
    np.testing.assert_allclose(-found.angle[:, 0] * steps / (2.0 * np.pi), motor, rtol=1e-10, atol=1e-6)
    np.testing.assert_allclose(unwound_lengths(robot, found.angle), unwound, rtol=1e-13)


def test_the_motion_of_drums_is_the_derivative_of_their_angles():
    robot, time = robot_with(efficiency=0.7, **GROWN), np.linspace(0.0, 1.0, 2001)
    length = home_lengths(robot) + 0.5 * np.sin(3.0 * time)[:, None]
    rate = np.repeat(1.5 * np.cos(3.0 * time)[:, None], 4, axis=1)
    found = drum_motion(robot, length, rate, np.repeat(-4.5 * np.sin(3.0 * time)[:, None], 4, axis=1))
    step = time[1]
    np.testing.assert_allclose(found.speed[1:-1], np.gradient(found.angle, step, axis=0)[1:-1], rtol=1e-4, atol=1e-3)
    turning = np.gradient(found.speed, step, axis=0)[1:-1]
    np.testing.assert_allclose(found.acceleration[1:-1], turning, atol=1e-4 * np.abs(turning).max())
    assert found.load[0, 0] == pytest.approx(0.7)  # the drum pays out
    assert found.load[1500, 0] == pytest.approx(0.7 if rate[1500, 0] > 0 else 1.0 / 0.7)


@pytest.mark.parametrize("model", ["elastic", "rigid"])
def test_defaults_change_no_bit(model):
    given = {"gear_ratio": 5.0, "efficiency": 1.0, "drum_growth": 0.0, "lines": 3, "reeving": 1}
    plain, same = (cdpr.simulate(camera(model, winch)) for winch in (DRUM, DRUM | given))
    assert equal(plain, same)


@pytest.mark.parametrize("model", ["elastic", "rigid"])
def test_a_tackle_is_a_smaller_drum(model):
    """Four falls are the drum of a quarter of the radius: the same bits, as the factor is a power of 2."""
    four = cdpr.simulate(camera(model, DRUM | {"reeving": 4}))
    small = cdpr.simulate(camera(model, DRUM | {"drum_radius": RADIUS / 4.0}))
    assert equal(four, small)
    plain = cdpr.simulate(camera(model))
    assert np.abs(four.position - plain.position).max() > 1e-6


@pytest.mark.parametrize("model", ["elastic", "rigid"])
def test_the_power_of_the_motors_goes_into_cables_inertia_friction_and_losses(model):
    winch = DRUM | GROWN | {"efficiency": 0.6, "coulomb_speed": 0.5}
    fine = {"simulation.control_step": 0.0005, "simulation.physics_step": 0.0005}
    run = cdpr.simulate(camera(model, winch, **fine))
    w, T = run["drum_speed"], run.cable_tension
    unwound = run.length if model == "rigid" else None
    g, n, k = GROWN.values()
    turned = RADIUS + 0.5 * g * n * run["drum_angle"]  # radius
    wound = (turned**2 - RADIUS**2) / (g * n * k)
    if unwound is not None:
        np.testing.assert_allclose(home_lengths(robot_with()) - wound, unwound, rtol=1e-12)
    lost = (1.0 - 0.6) * np.tanh(w / 0.5)
    load = (1.6 + lost) / (1.6 - lost)
    useful = turned / k * T * w
    assert (useful * (load - 1.0) >= 0.0).all()
    assert (np.abs(useful * (load - 1.0)).max(axis=0) > 1.0).all()  # W
    kinetic = INERTIA * w * np.gradient(w, run.time, axis=0)
    spent = useful * load + VISCOUS * w**2 + kinetic
    # commands are held for a period: within it the tension, and so the acceleration, change little
    np.testing.assert_allclose(run["motor_power"][2:-1], spent[2:-1], atol=2e-3 * np.abs(spent).max())
    np.testing.assert_allclose(run["motor_torque"], turned / k * run.tension, rtol=1e-12)


@pytest.mark.parametrize("model", ["elastic", "rigid"])
def test_the_angle_is_the_integral_of_the_speed(model):
    run = cdpr.simulate(camera(model, DRUM | GROWN))
    angle, speed, step = run["drum_angle"], run["drum_speed"], run.time[1]
    np.testing.assert_allclose(np.diff(angle, axis=0), 0.5 * step * (speed[1:] + speed[:-1]), atol=2e-4)
    np.testing.assert_allclose(run["motor_power"], run["motor_torque"] * speed)
    assert np.abs(angle[0]).max() < (1e-9 if model == "rigid" else 2.0)  # an elastic cable starts stretched


def test_the_radius_of_a_servo_grows_and_its_unwound_lengths_do_not_change():
    servo = DRUM | {"type": "position", "velocity_gain": 2.0, "position_gain": 60.0, "integral_gain": 40.0}
    follow = {"controller": {"type": "inverse_kinematics"}, "simulation.duration": 3.0}
    plain, grown = (cdpr.simulate(camera(winch=winch, **follow)) for winch in (servo, servo | GROWN))
    lengths = plain["unstretched_length"][-1]
    np.testing.assert_allclose(grown["unstretched_length"][-1], lengths, atol=1e-5)
    expected = drum_motion(robot_with(**GROWN), lengths[None], 0.0 * lengths[None], 0.0 * lengths[None])
    np.testing.assert_allclose(grown["drum_angle"][-1], expected.angle[0], rtol=1e-4)
    torque = expected.per_turn[0] * grown.cable_tension[-1]
    np.testing.assert_allclose(grown["motor_torque"][-1], torque, rtol=1e-3)


@pytest.mark.parametrize("backend", installed("mujoco", "bullet", "dart"))
def test_engines_agree_with_the_reference(backend):
    euler = {"backend_options.reference.scheme": "semi_implicit_euler", "simulation.duration": 0.5}
    scenario = camera(winch=DRUM | GROWN | {"efficiency": 0.8}, **euler)
    ours, theirs = (cdpr.simulate(scenario, backend=each) for each in ("reference", backend))
    assert np.abs(ours.position - theirs.position).max() < 1e-11
    assert np.abs(ours["drum_angle"] - theirs["drum_angle"]).max() < 1e-9


def test_the_exported_robot_has_the_same_drums():
    scenario = camera(winch=DRUM | GROWN | {"efficiency": 0.8}, **{"simulation.duration": 0.1})
    ours, theirs = (cdpr.simulate(scenario, backend=each) for each in ("reference", "fmu"))
    for name in ("position", "drum_angle", "drum_speed", "motor_torque", "motor_power"):
        np.testing.assert_allclose(theirs[name], ours[name], rtol=1e-9, atol=1e-9, err_msg=name)


def test_equilibria_of_drum_angles():
    robot = robot_with(**GROWN)
    lengths = np.linalg.norm(ANCHORS - GOAL, axis=1)
    angles = drum_motion(robot, lengths[None], np.zeros((1, 4)), np.zeros((1, 4))).angle[0]
    by_angle, by_length = (
        cdpr.equilibrium(robot, **given) for given in ({"drum_angles": angles}, {"lengths": lengths})
    )
    np.testing.assert_allclose(by_angle.pose, by_length.pose, atol=1e-9)
    with pytest.raises(CdprError, match="at -1e\\+06 rad the drum is empty"):
        cdpr.equilibrium(robot, drum_angles=[-1e6] * 4)


def test_a_drum_that_is_empty_after_the_smallest_motion_is_named():
    """At the start, the length is that of the home pose, at which the drum has its radius."""
    changes = {"robot.winch.drum_growth": 1e9, "simulation.duration": 0.1}
    with pytest.raises(SimulationStopped, match=r"the state is not finite; cable 'cable_1': its drum is empty"):
        cdpr.simulate("winch", overrides=changes)


@pytest.mark.parametrize("model", ["elastic", "rigid"])
def test_an_empty_drum_ends_the_run_with_its_name(model):
    with pytest.raises(SimulationStopped, match=r"cable 'cable_1': its drum is empty at a length of"):
        cdpr.simulate(camera(model, DRUM | {"drum_growth": 4e-3}))


def test_impossible_numbers_are_rejected():
    with pytest.raises(ScenarioError, match=r"efficiency.*less than or equal to 1|efficiency.*1"):
        camera(winch=DRUM | {"efficiency": 1.2})
    with pytest.raises(ScenarioError, match="reeving"):
        camera(winch=DRUM | {"reeving": 0})
    with pytest.raises(ScenarioError, match=r"drum_growth: needs winch\.drum_radius"):
        camera(winch={"type": "position", "drum_growth": 1e-5})
    push = {"robot.unilateral": False}
    with pytest.raises(ScenarioError, match="efficiency: not supported for rigid legs"):
        camera(winch=DRUM | {"efficiency": 0.9}, **push)
    robot = robot_with()
    winch = Winch(drum_radius=0.1, inertia=0.1, own={"efficiency": 0.9})
    cables = tuple(replace(cable, winch=winch) for cable in robot.cables)
    legs = replace(robot, cables=cables, unilateral=False)
    with pytest.raises(CdprError, match="efficiency: not supported for rigid legs"):
        drum_motion(legs, np.ones((1, 4)), np.ones((1, 4)), np.ones((1, 4)))


@pytest.mark.parametrize("inertia", [{}, {"inertia": INERTIA}])
def test_drums_use_the_numbers_that_their_winch_accepts(inertia):
    """All winches with a drum, also steppers and those that do not turn in runs, have block and tackle."""
    winch = {"type": "stepper", "drum_radius": RADIUS, "stall_torque": 50.0, "reeving": 2} | inertia
    stepper, angles = camera(winch=winch).robot, np.full((1, 4), 5.0)
    assert unwound_lengths(stepper, angles) == pytest.approx(home_lengths(stepper)[None] - 2.5 * RADIUS, rel=1e-12)
    ideal = replace(robot_with(reeving=2), cable_model="ideal")  # the drums of winches that do not turn in runs
    assert unwound_lengths(ideal, angles) == pytest.approx(home_lengths(ideal)[None] - 2.5 * RADIUS, rel=1e-12)
