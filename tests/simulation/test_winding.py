"""Robots whose winches hold lengths or rates: resting poses against statics, limits, maps, uses and messages."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from log_cases import same_bits
from plants import installed
from scipy.optimize import least_squares

import cdpr
from cdpr.model.cable import Winch

ANCHORS = np.array([[-2.0, -2.0, 3.0], [2.0, -2.0, 3.0], [2.0, 2.0, 3.0], [-2.0, 2.0, 3.0]])
GOAL = np.array([0.8, 0.5, 1.5])
MASS, GRAVITY = 10.0, 9.81
LOST = {2e3: 143.279, 2e4: 15.658, 2e5: 1.582}  # mm, closed-form statics of a camera robot whose drums hold lengths
AT_REST = 1e-6  # m, required
SERVO = {"type": "position", "drum_radius": 0.05, "inertia": 0.002, "velocity_gain": 1.0, "position_gain": 50.0}
SERVO["integral_gain"] = 20.0
INVERSE = {"type": "inverse_kinematics"}


def camera(stiffness=2e4, winch=None, **changes):
    """Return a platform on four lines that moves to GOAL in 1 s and then rests."""
    data = {
        "robot": {
            "name": "camera",
            "dof": ["x", "y", "z"],
            "platform": {"mass": MASS},
            "tension": {"min": 0, "max": 400},
            "home": {"position": [0.0, 0.0, 1.0]},
            "cable": {"model": "elastic", "axial_stiffness": stiffness, "damping": 1.1 * stiffness**0.5},
            "winch": winch or {"type": "position"},
            "cables": [{"frame": A.tolist(), "platform": [0, 0, 0]} for A in ANCHORS],
        },
        "simulation": {"backend": "reference", "duration": 8.0, "control_step": 0.002, "physics_step": 0.001},
        "trajectory": {"type": "quintic", "duration": 1.0, "to": {"position": GOAL.tolist()}},
        "controller": INVERSE,
    }
    return cdpr.load_scenario(data, overrides=changes)


def resting_place(lengths, stiffness, start=GOAL):
    """Return the position (3,) at which tensions E A (l - l0) / l0 balance the weight, by another method."""

    def force(position):
        chord = np.linalg.norm(ANCHORS - position, axis=1)
        tension = np.maximum(stiffness * (chord - lengths) / lengths, 0.0)
        return (tension / chord) @ (ANCHORS - position) - [0.0, 0.0, MASS * GRAVITY]

    return least_squares(force, start, xtol=1e-15, ftol=1e-15, gtol=1e-15).x


@pytest.mark.parametrize("stiffness", LOST)
def test_drums_that_hold_lengths_leave_the_platform_where_its_cables_stretch_to(stiffness):
    run = cdpr.simulate(camera(stiffness))
    lengths = np.linalg.norm(ANCHORS - GOAL, axis=1)
    assert np.abs(run["unstretched_length"][-1] - lengths).max() < AT_REST
    assert np.linalg.norm(run.position[-1] - resting_place(lengths, stiffness)) < AT_REST
    assert 1e3 * np.linalg.norm(run.position[-1] - GOAL) == pytest.approx(LOST[stiffness], abs=1e-3)
    assert np.abs(run.velocity[-1]).max() < AT_REST


@pytest.mark.parametrize("winch", [{"type": "position"}, SERVO])
def test_flex_compensation_brings_it_to_its_goal(winch):
    options = {"controller.flex_compensation": True}
    run = cdpr.simulate(camera(winch=winch, **options))
    assert np.linalg.norm(run.position[-1] - GOAL) < AT_REST
    np.testing.assert_allclose(run.winch_command[-1], run["unstretched_length"][-1], atol=AT_REST)


def test_servos_with_higher_gains_approach_ideal_drives():
    """The difference is of the first order in the reciprocal of the position gain."""
    steps = {"simulation.control_step": 0.0005, "simulation.physics_step": 0.0001, "simulation.duration": 1.0}
    ideal = cdpr.simulate(camera(**steps))
    apart = []
    for gain in (50.0, 100.0, 200.0):
        gains = {"position_gain": gain, "velocity_gain": 10.0, "integral_gain": 0.0}
        run = cdpr.simulate(camera(winch=SERVO | gains, **steps))
        apart.append(np.linalg.norm(run.position - ideal.position, axis=1).max())
    orders = np.log2(np.divide(apart[:-1], apart[1:]))
    assert (orders > 0.8).all(), apart


@pytest.mark.parametrize("backend", installed("mujoco", "bullet", "dart"))
def test_engines_agree_with_the_reference(backend):
    scenario = camera(
        winch=SERVO, **{"simulation.duration": 1.0, "backend_options.reference.scheme": "semi_implicit_euler"}
    )
    ours, theirs = (cdpr.simulate(scenario, backend=each) for each in ("reference", backend))
    assert np.abs(ours.position - theirs.position).max() < 1e-11
    assert np.abs(ours["unstretched_length"] - theirs["unstretched_length"]).max() < 1e-11


@pytest.mark.parametrize(
    ("kind", "controller"), [*product(("position", "velocity"), ("computed_torque", "cable_length"))]
)
def test_controllers_of_wrenches_and_tensions_drive_them_by_the_map(kind, controller):
    """Little damping, so that cables stay taut; the same goal as with torque winches."""
    gains = {"kp": 3000.0, "kd": 300.0} if controller == "cable_length" else {"kp": 40.0, "kd": 12.0}
    changes = {"controller": {"type": controller, **gains}, "robot.cable.damping": 5.0, "simulation.duration": 3.0}
    run = cdpr.simulate(camera(winch={"type": kind}, **changes))
    assert np.linalg.norm(run.position[-1] - GOAL) < 2e-4
    assert np.abs(run.cable_tension[1:] - run.tension[:-1]).max() < 2.0  # the tension at the end of the period


def test_the_map_is_that_of_the_nominal_robot():
    wrong = {"robot.cable.axial_stiffness": 2e4, "believed": {"cable": {"axial_stiffness": 1e4}}}
    changes = {"controller": {"type": "computed_torque"}, "robot.cable.damping": 5.0, "simulation.duration": 0.1}
    run = cdpr.simulate(camera(**changes | wrong))
    np.testing.assert_allclose(run.cable_tension[0] / run.tension[0], 2.0, rtol=1e-9)


def test_cables_of_one_robot_differ():
    """One line at a constant tension, the others at lengths."""
    one = {"robot.cables[0].winch": {"type": "torque", "drum_radius": 0.05, "inertia": 0.002, "viscous_friction": 0.05}}
    run = cdpr.simulate(camera(**one))
    lengths = np.linalg.norm(ANCHORS - GOAL, axis=1)
    np.testing.assert_allclose(run.winch_command[-1, 1:], lengths[1:], atol=AT_REST)
    assert run.cable_tension[-1, 0] == pytest.approx(run.winch_command[-1, 0], abs=1e-3)
    assert run["motor_torque"][-1, 0] == pytest.approx(0.05 * run.winch_command[-1, 0])
    assert np.isnan(run["motor_torque"][:, 1:]).all()


@pytest.mark.parametrize("load", [{}, {"events": [{"type": "payload", "time": 0.0, "mass": 5.0}]}])
@pytest.mark.parametrize("believed", [{}, {"believed": {"platform": {"mass": 8.0}}}])
def test_rates_start_from_tensions_that_hold_the_platform(load, believed):
    """With a payload of the first sample, and also if the nominal mass is wrong."""
    still = {"trajectory": {"type": "hold"}, "simulation.duration": 0.5}
    run = cdpr.simulate(camera(winch={"type": "velocity"}, **still, **load, **believed))
    assert np.abs(run.position - run.position[0]).max() < AT_REST
    assert not run.winch_command.any()


@pytest.mark.parametrize("winch", [{"type": "position"}, {"type": "velocity"}, SERVO])
def test_snapshots_rollouts_and_files_repeat_the_run(winch, tmp_path):
    scenario = camera(winch=winch, **{"simulation.duration": 0.4})
    run = cdpr.simulate(scenario)
    with cdpr.Simulation(scenario) as simulation:
        simulation.step(60)
        middle = simulation.snapshot()
        simulation.step(50)
        simulation.restore(middle)
        simulation.step(50)
        again = simulation.state[:3].copy()
    assert same_bits(again, run.position[110])
    found = cdpr.rollout(scenario, 2, vary={"robot.platform.mass": [MASS, 11.0]}, columns=["position"], threads=1)
    assert same_bits(found["position"][0], run.position[::2])  # at 101 samples
    scenario.save(tmp_path / "saved.yaml")
    assert same_bits(cdpr.simulate(tmp_path / "saved.yaml").position, run.position)


def test_winches_built_in_python():
    robot = cdpr.Robot.from_points(ANCHORS, np.zeros((4, 3)), mass=MASS, dof=("x", "y", "z"), home=[0.0, 0.0, 1.0])
    cables = [
        each.replace(
            winch=Winch(type="position"), axial_stiffness=2e4, damping=50.0, model="elastic", tension_max=400.0
        )
        for each in robot.cables
    ]
    scenario = cdpr.Scenario(robot=robot.replace(cables=cables), controller=INVERSE, simulation={"duration": 0.1})
    assert cdpr.simulate(scenario).status == "finished"
    assert cdpr.load_robot(scenario.robot.to_dict()).cables[0].winch.type == "position"


MESSAGES = {
    "inextensible": (
        {"robot.cable.model": "rigid"},
        "position needs a cable that stretches, got cable.model rigid",
    ),
    "type": ({"robot.winch.type": "rope"}, "robot.winch.type"),
    "gain": (
        {"robot.winch": {"type": "position", "drum_radius": 0.05, "inertia": 0.002}},
        "cable.model elastic with winch.type position needs the gain of the velocity loop (N m s) of each cable",
    ),
    "actuators": ({"actuators": {}}, "actuators: their commands are tensions: set robot.winch.type to torque"),
    "backend": (
        {"simulation.backend": "mujoco", "backend_options": {"mujoco": {"cables": "native"}}},
        "does not support",
    ),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_messages(name):
    changes, text = MESSAGES[name]
    with pytest.raises(cdpr.CdprError) as caught:
        cdpr.simulate(camera(**changes))
    assert text in str(caught.value)


TORQUE = {"type": "torque", "drum_radius": 0.05, "inertia": 0.002}
BELIEVED = {
    "tension": ({"type": "position"}, {"winch": TORQUE}, "a length, got a tension"),
    "rate": ({"type": "position"}, {"winch": {"type": "velocity"}}, "a length, got a rate"),
    "length": (TORQUE, {"winch": {"type": "position"}}, "a tension, got a length"),
}


@pytest.mark.parametrize("name", BELIEVED)
def test_the_nominal_model_has_the_same_commands(name):
    winch, believed, text = BELIEVED[name]
    with pytest.raises(cdpr.CdprError, match=rf"believed\.winch\.type: must have the command of .*, {text}"):
        camera(winch=winch, believed=believed)


def test_the_map_drives_the_true_winch_if_the_nominal_one_is_a_servo():
    changes = {"controller": {"type": "computed_torque"}, "robot.cable.damping": 5.0, "simulation.duration": 0.1}
    expected = cdpr.simulate(camera(**changes))
    run = cdpr.simulate(camera(believed={"winch": SERVO}, **changes))
    assert same_bits(run.winch_command, expected.winch_command)
    assert same_bits(run.position, expected.position)


@pytest.mark.parametrize("category", [0, 1])
@pytest.mark.parametrize("kind", ["position", "velocity"])
def test_power_cuts_are_rejected(kind, category):
    stop = {"events": [{"type": "emergency_stop", "time": 0.5, "category": category}]}
    with pytest.raises(cdpr.CdprError, match=rf"and robot\.winch\.type is {kind}: set robot\.winch\.brake_torque"):
        camera(winch={"type": kind}, **stop)
    one = {"robot.cables[0].winch": {"type": kind}, "controller": {"type": "computed_torque"}}
    with pytest.raises(cdpr.CdprError, match=r"set robot\.cables\[0\]\.winch\.brake_torque"):
        camera(winch=TORQUE, **one, **stop)


def test_a_stop_that_holds_the_pose_is_supported():
    stop = {"events": [{"type": "emergency_stop", "time": 0.1}], "simulation.duration": 1.0}
    run = cdpr.simulate(camera(**stop))
    assert np.ptp(run.winch_command[-100:], axis=0).max() < AT_REST


def test_numbers_that_no_winch_uses_are_reported():
    """Without an inertia, a drive is ideal and has no gains; a velocity servo has no position loop."""
    gains = {"velocity_gain": 1.0, "torque_max": 5.0}
    assert set(camera(winch={"type": "position", **gains}).unused) == {f"robot.winch.{key}" for key in gains}
    assert camera(winch=SERVO).unused == ()
    assert camera(winch=SERVO | {"type": "velocity", "position_gain": 30.0}).unused == ("robot.winch.position_gain",)
    one = {"robot.cables[1].winch": TORQUE | gains, "controller": {"type": "computed_torque"}}
    assert set(camera(winch=SERVO, **one).unused) == {f"robot.cables[*].winch.{key}" for key in gains}


class Observer(cdpr.plugins.Controller):
    """Hold the lengths of the start, and keep the observed tensions."""

    output = "length"

    def observe(self, inputs):
        self.inputs, Observer.seen = inputs, []

    def control(self, time, state, desired, out):
        Observer.seen.append(self.inputs.command.copy())
        out[:] = 0.99 * np.linalg.norm(ANCHORS - [0.0, 0.0, 1.0], axis=1)


def test_controllers_observe_the_tensions_of_their_lengths():
    run = cdpr.simulate(camera(**{"simulation.duration": 0.02}), controller=Observer)
    assert same_bits(np.array(Observer.seen[-len(run.tension) + 1 :]), run.tension[:-1])
    assert (run.tension > 0.0).all()


def test_messages_name_the_command():
    class Invalid(Observer):
        def control(self, time, state, desired, out):
            out[:] = np.nan if time > 0.005 else 2.0

    with pytest.raises(cdpr.CdprError, match="the controller's command is not finite"):
        cdpr.simulate(camera(), controller=Invalid)


def test_cables_that_sag_need_a_pretension():
    sagging = {"robot.winch": {"type": "position"}, "simulation.duration": 0.01}
    scenario = cdpr.load_scenario("sagging", overrides=sagging | {"controller": INVERSE})
    with pytest.raises(cdpr.CdprError, match=r"controller\.pretension: expected at least 22\.36 N"):
        cdpr.simulate(scenario)
    assert cdpr.simulate(scenario, overrides={"controller.pretension": 100.0}).status == "finished"


class TooHigh(cdpr.plugins.Controller):
    """One line at a tension beyond its limits from 0.01 s on, the others at constant lengths."""

    output = "command"

    def control(self, time, state, desired, out):
        out[:] = np.linalg.norm(ANCHORS - [0.0, 0.0, 1.0], axis=1)
        out[0] = 100.0 if time < 0.009 else 500.0


@pytest.mark.parametrize("policy", ["best_effort", "stop"])
def test_commanded_tensions_beyond_the_limits(policy):
    one = {"robot.cables[0].winch": TORQUE, "solver.infeasible": policy, "simulation.duration": 0.03}
    if policy == "stop":
        with pytest.raises(cdpr.LimitViolation, match=r"t = 0\.01 s: the controller's command is beyond") as caught:
            cdpr.simulate(camera(**one), controller=TooHigh)
        run = caught.value.run
        assert len(run.time) == 6
    else:
        run = cdpr.simulate(camera(**one), controller=TooHigh)
        assert [event.text for event in run.events if event.kind == "not_found"] == [
            "the controller's command is beyond the tension limits; it was clipped (11 samples)"
        ]
    assert run.winch_command[4:6, 0].tolist() == [100.0, 400.0]
    assert run.solver_status[4:6].tolist() == [cdpr.tension.Status.OK, cdpr.tension.Status.NOT_FOUND]


def test_the_last_row_of_an_infeasible_run_has_its_own_commands():
    changes = {"controller": {"type": "computed_torque"}, "solver.infeasible": "stop", "simulation.duration": 0.5}
    push = {"type": "wrench", "time": 0.1, "force": [0, 0, -200.0]}
    limit = {"type": "limits", "time": 0.1, "max": 20.0}
    with pytest.raises(cdpr.Infeasible) as caught:
        cdpr.simulate(camera(**changes, drives={"delay": 0.004}, events=[push, limit]))
    run = caught.value.run
    rest = run.tension[-1] / 2e4
    wanted = run.length[-1] / (1.0 + rest)
    later = 0.002 * run.rate[-1] / (1.0 + rest)  # an ideal drive reaches it at the end of the period
    np.testing.assert_allclose(run.winch_command[-1], wanted + later, rtol=0.0, atol=1e-12)
    assert same_bits(run["drive_command"][-1], run.winch_command[-3])


def test_a_start_without_equilibrium_is_reported():
    """Lengths of unloaded cables have no tension at the start; compensated lengths and rates start at rest."""
    (event,) = (
        event for event in cdpr.simulate(camera(**{"simulation.duration": 0.1})).events if event.kind == "start"
    )
    assert event.text.startswith(
        "the cables do not hold the platform at the start: 98.1 N of 98.1 N are not balanced, and it moves"
    )
    still = {"simulation.duration": 0.1, "controller.flex_compensation": True}
    for winch in ({"type": "position"}, SERVO):
        assert [e for e in cdpr.simulate(camera(winch=winch, **still)).events if e.kind == "start"] == []
    rates = camera(winch={"type": "velocity"}, **{"trajectory": {"type": "hold"}, "simulation.duration": 0.1})
    assert [e for e in cdpr.simulate(rates).events if e.kind == "start"] == []


def test_flex_compensation_includes_the_weight_of_the_ropes():
    """Without half of their weight, 0.9 kN on the platform of about 5 kN, it would rest lower."""
    own = {"robot.winch": {"type": "position"}, "trajectory": {"type": "hold"}, "simulation.duration": 0.2}
    compensated = INVERSE | {"flex_compensation": True, "pretension": 1000.0}
    run = cdpr.simulate("sagging", overrides={**own, "controller": compensated})
    assert np.linalg.norm(run.position - run.position[0], axis=1).max() < 1e-6
    assert np.abs(run["bending_wrench"][0, 2]) > 50.0
