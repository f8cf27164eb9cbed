"""The controller `pid`: its law, its integral and its anti-windup."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from conftest import GRAVITY, ROOT, random_state

import cdpr
from cdpr.mechanics import dynamics, kinematics
from cdpr.model import rotations
from cdpr.tension import Status
from cdpr_controllers import PidOptions
from cdpr_controllers.pid import Pid

pytestmark = pytest.mark.core

STEP = 2e-3


def make(robot, **options):
    return Pid(robot, GRAVITY, STEP, PidOptions(**options))


def ask(controller, state, desired):
    out = np.full(6, np.nan)
    controller.control(0.0, state, desired, out)
    return out


@pytest.fixture
def case(offset_robot):
    """A robot, a state and a target at rest 0.1 m and 0.2 rad away; the error (6,)."""
    state = kinematics.make_state([0.1, 0.2, 1.5], rotations.from_rpy(0.2, -0.1, 0.4))
    error = np.array([0.1, -0.05, 0.02, 0.0, 0.2, 0.0])
    desired = np.zeros(19)
    desired[:3] = state[:3] + error[:3]
    desired[3:7] = rotations.multiply(rotations.from_axis_angle(np.array([0.0, 1.0, 0.0]), 0.2), state[3:7])
    return offset_robot, state, desired, error


def wanted(robot, state, acceleration):
    still = np.concatenate([state[:7], np.zeros(6)])
    return dynamics.required_wrench(robot, still, GRAVITY, acceleration[:3], acceleration[3:])


def test_the_law_with_gains_per_direction(offset_robot):
    rng = np.random.default_rng(1)
    state, target = random_state(rng), random_state(rng)
    kp, kd, ki = rng.uniform(1, 50, (3, 6))
    controller = make(offset_robot, kp=tuple(kp), kd=tuple(kd), ki=tuple(ki), integral_limit=1e6)
    turn = rotations.rotation_vector(rotations.multiply(target[3:7], rotations.conjugate(state[3:7])))
    e = np.concatenate([target[:3] - state[:3], turn])
    for count in (1, 2, 3):
        out = ask(controller, state, np.concatenate([target, rng.normal(size=6)]))
        a = kp * e + count * STEP * ki * e + kd * (target[7:] - state[7:])
        np.testing.assert_allclose(out, wanted(offset_robot, state, a), rtol=1e-10, atol=1e-9)


def test_the_integral_stays_within_its_limit_and_reset_clears_it(case):
    robot, state, desired, error = case
    limit = np.array([1.0, 0.5, 10.0, 1.0, 0.3, 1.0])
    controller = make(robot, kp=0.0, kd=0.0, ki=100.0, integral_limit=tuple(limit))
    first = ask(controller, state, desired)
    for _ in range(2000):
        last = ask(controller, state, desired)
    expected = np.where(np.abs(error) > 0, np.sign(error) * np.minimum(limit, 2001 * STEP * 100 * np.abs(error)), 0.0)
    np.testing.assert_allclose(last, wanted(robot, state, expected), atol=1e-6)
    controller.reset()
    np.testing.assert_array_equal(ask(controller, state, desired), first)


def test_while_the_cables_cannot_follow_the_integral_only_unwinds(case):
    robot, state, desired, error = case
    controller = make(robot, kp=0.0, kd=0.0, ki=100.0)
    report = np.zeros(4)
    controller.connect(report)
    for _ in range(3):
        before = ask(controller, state, desired)
    report[0] = Status.INFEASIBLE
    np.testing.assert_array_equal(ask(controller, state, desired), before)
    back = desired.copy()
    back[:3] = state[:3] - error[:3]
    back[3:7] = state[3:7]
    after = ask(controller, state, back)
    unwound = np.concatenate([2 * error[:3], 3 * error[3:]]) * STEP * 100
    np.testing.assert_allclose(after, wanted(robot, state, unwound), atol=1e-9)
    report[0] = Status.OK
    np.testing.assert_allclose(
        ask(controller, state, desired), wanted(robot, state, unwound + error * STEP * 100), atol=1e-9
    )


WRONG_MASS = {
    "simulation.duration": 8.0,
    "world.gravity": [0, 0, -9.81],
    "trajectory": {"type": "hold"},
}


def steady_error(ki: float) -> float:
    """Error at the end of a hold, with a controller that believes in less gravity than there is."""
    from cdpr.simulation.build import build
    from cdpr.simulation.loop import Loop

    scenario = cdpr.load_scenario(ROOT / "scenarios" / "caroca.yaml", overrides=WRONG_MASS, controller="pid")
    parts = build(scenario)
    options = PidOptions(kp=100.0, kd=20.0, ki=ki)
    wrong = Pid(parts.robot, 0.9 * GRAVITY, parts.control_step, options)
    loop = Loop(dataclasses.replace(parts, controller=wrong))
    rows = np.empty((scenario.simulation.steps + 1, len(loop.row)))
    loop.run(rows, lambda _: None)
    return float(np.linalg.norm(loop.state[:3] - loop.desired[:3]))


def test_the_integral_compensates_an_unknown_load():
    assert steady_error(0.0) == pytest.approx(0.1 * 9.81 / 100.0, rel=1e-3)
    assert steady_error(200.0) < 1e-6


def test_the_loop_notifies_of_infeasible_steps():
    """Weaker cables than the weight needs: without anti-windup the integral would reach its limit."""
    overrides = {"robot.tension": {"min": 50, "max": 300}, "simulation.duration": 1.0, "trajectory": {"type": "hold"}}
    run = cdpr.simulate(
        ROOT / "scenarios" / "caroca.yaml",
        controller="pid",
        overrides={**overrides, "controller": {"type": "pid", "kp": 0, "kd": 0, "ki": 100}},
    )
    assert run.solver_status.all()
    weight = 150 * 9.81
    # It falls; the integral received only the first step, at zero error.
    assert run["wrench"][-1, 2] == pytest.approx(weight, rel=1e-3)
