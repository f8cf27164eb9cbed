"""A plant that goes wrong is caught in the step in which it does, and what came before is kept."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from conftest import ROOT
from plants import installed
from spread import sampled

import cdpr
from cdpr.base.errors import Diverged
from cdpr.simulation.build import build
from cdpr.simulation.faults import FAULTS as FAULT_TEXTS
from cdpr.simulation.loop import Loop
from cdpr.simulation.observe import Body, Observation, PlantOutputs, acceleration_bounds, observing
from cdpr_backends.reference import ReferenceBackend

CAROCA = ROOT / "scenarios" / "caroca.yaml"
MOVING = 20  # steps; at rest in its initial pose a reset body differs from a sound one by its clock only


def nan(backend):
    backend.state[8] = np.nan


def infinite(backend):
    backend.state[0] = np.inf


def absurd_speed(backend):
    backend.state[7] = 2e3


def absurd_spin(backend):
    backend.state[12] = 1e5


def shrunk_quaternion(backend):
    backend.state[3:7] *= 0.99


def jump(backend):
    backend.state[1] += 1e-3


def turn(backend):
    backend.state[3:7] = [np.cos(0.005), 0, 0, np.sin(0.005)]
    backend.state[3:7] /= np.linalg.norm(backend.state[3:7])


def reset(backend):
    """Default reaction of MuJoCo to a bad acceleration: finite values, and a restart."""
    backend.reset(cdpr.load_scenario(CAROCA).initial.state())


class Faulty:
    """A backend whose state is spoilt after a chosen step."""

    def __init__(self, backend, fault, when):
        self._backend, self._fault, self._when, self.calls = backend, fault, when, 0

    def __getattr__(self, name):
        return getattr(self._backend, name)

    def step(self, n):
        self._backend.step(n)
        self.calls += 1
        if self.calls == self._when:
            self._fault(self._backend)


def small_jump(backend):
    """Twice of what the strongest acceleration explains in a step."""
    backend.state[1] += 2.5 * 1e-6 * (2 * 3500 / 150 + 9.81)


FAULTS = {
    nan: "not finite",
    infinite: "not finite",
    absurd_speed: "absurdly fast",
    absurd_spin: "absurdly fast",
    shrunk_quaternion: "not of unit length",
    jump: "the pose jumped",
    small_jump: "the pose jumped",
    turn: "the pose jumped",
    reset: "the pose jumped",
}


@sampled(1, "backend", installed("reference", "mujoco"))
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_each_fault_is_found_in_its_own_step(backend, fault):
    scenario = cdpr.load_scenario(
        CAROCA, backend=backend, overrides={"simulation.duration": 1.5, "trajectory.duration": 1.5}
    )
    for when in np.random.default_rng(1).integers(MOVING, 1400, 6):
        parts = build(scenario)
        plant = Faulty(parts.backend, fault, when)
        loop = Loop(dataclasses.replace(parts, backend=plant))
        rows = np.empty((scenario.simulation.steps + 1, len(loop.row)))
        with pytest.raises(Diverged, match=rf"^t = {when / 1000:g} s: .*{FAULTS[fault]}"):
            loop.run(rows, lambda _: None)
        assert loop.count == when  # samples 0 ... when - 1 are kept
        assert np.isfinite(rows[: loop.count]).all()


def test_a_reset_at_the_start_pose_shows_in_the_engines_clock():
    scenario = cdpr.load_scenario(CAROCA, backend="mujoco", overrides={"trajectory": {"type": "hold"}})
    parts = build(scenario)
    loop = Loop(dataclasses.replace(parts, backend=Faulty(parts.backend, reset, 7)))
    rows = np.empty((scenario.simulation.steps + 1, len(loop.row)))
    with pytest.raises(Diverged, match="clock reads 0 s"):
        loop.run(rows, lambda _: None)
    assert loop.count == 7


def test_a_cable_without_length_is_found():
    """The anchor of the first cable, seen from a state that brings the platform's anchor there."""
    robot = cdpr.load_robot(ROOT / "scenarios" / "robots" / "caroca.yaml")
    anchors = robot.anchors.copy()
    state = np.concatenate([anchors[0, :3] - anchors[0, 3:], [1, 0, 0, 0], np.zeros(6)])
    W, lengths, rates = np.zeros((6, 8)), np.zeros(8), np.zeros(8)
    body = Body(anchors, robot.inertial, np.zeros(3), acceleration_bounds(robot, np.zeros(3)))
    seen = Observation(state.copy(), W, lengths, rates, np.zeros(4))
    fault = observing(body, PlantOutputs(state, np.zeros(6), np.zeros(8)), seen, 0.0)()
    assert FAULT_TEXTS[fault] == "a cable has no length"


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
def test_long_control_periods_of_a_swinging_platform_raise_no_alarm(backend):
    """Motion that goes to and fro within a control period, as pretension makes it."""
    run = cdpr.simulate(
        CAROCA,
        backend=backend,
        controller="static",
        overrides={
            "simulation": {"duration": 2.0, "control_step": 0.1, "physics_step": 1e-3},
            "trajectory": {"type": "hold"},
            "robot.tension.min": 500,
            "controller.kp": 0.0,
            "controller.kd": 0.0,
            "initial.angular_velocity": [0.0, 0.0, 0.2],
        },
    )
    assert run.status == "finished"


def test_sound_runs_raise_no_alarm():
    """Fast spins and throws, with long control periods: far from any limit of the guards."""
    for step in (1e-3, 1e-2):
        for backend in installed("reference", "mujoco"):
            run = cdpr.simulate(
                CAROCA,
                backend=backend,
                controller="static",
                overrides={
                    "simulation": {"duration": 0.5, "control_step": step, "physics_step": 1e-3},
                    "initial.velocity": [5.0, -3.0, 8.0],
                    "initial.angular_velocity": [8.0, 20.0, -10.0],
                    "controller.kp": 0.0,
                    "controller.kd": 0.0,
                    "robot.platform.center_of_mass": [0.1, 0.1, -0.1],
                },
            )
            assert run.status == "finished"


def test_a_diverged_run_is_kept_and_reported(tmp_path):
    """Far too high gains for the control period."""
    overrides = {"controller.kp": 1e6, "controller.kd": 1e5, "initial.position": [0.1, 0, 1.2]}
    with pytest.raises(cdpr.Diverged) as caught:
        cdpr.simulate(CAROCA, overrides={**overrides, "robot.tension.max": 1e9}, out=tmp_path / "run")
    run = caught.value.run
    assert run.status == "diverged"
    assert len(run.rows) > 1
    assert run.events[-1].kind == "diverged"
    loaded = cdpr.load_run(tmp_path / "run")
    assert loaded.status == "diverged"
    assert loaded.message == run.message
    np.testing.assert_array_equal(loaded.rows, run.rows)


@pytest.mark.parametrize("backend", installed("reference", "mujoco", "bullet", "dart"))
def test_a_slack_robot_that_swings_about_what_holds_it_raises_no_alarm(backend):
    """No cable pulls, the centre of mass lies off the ball: weight alone turns the table, through the ball's force."""
    knock = {"type": "wrench", "time": 0.031, "duration": 0.003, "moment": [0.16, 0.64, -1.62]}
    run = cdpr.simulate(
        ROOT / "scenarios" / "spherical.yaml",
        backend=backend,
        overrides={
            "simulation": {"duration": 0.2, "physics_step": 0.0005},
            "events": [{"type": "emergency_stop", "time": 0.03, "category": 0}, knock],
        },
    )
    assert run.status == "finished"
    assert run.tension[50:].max() == 0.0


def test_a_clock_that_is_no_number_is_off():
    class Lost(ReferenceBackend):
        def engine_time(self):
            return math.nan if self.state[7:10].any() else 0.0

    with pytest.raises(Diverged, match="clock reads nan s"):
        cdpr.simulate(CAROCA, backend=Lost)
