"""Platforms on a ball at their origin: against Euler's equations about a fixed point, and what these conserve."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from conftest import GRAVITY
from oracle import oracle
from plants import installed, plant
from scipy.integrate import solve_ivp

from cdpr.mechanics.energy import energy
from cdpr.model import rotations
from cdpr.model.robot import frozen_array
from cdpr.testing import samples

ENGINES = installed("mujoco", "bullet", "dart")
ALL = ["reference", *ENGINES]
BALL = ("rx", "ry", "rz")

EXACT = 1e-9  # rad, rad/s after 0.3 s at 0.5 ms; measured 2e-11
SAME_SCHEME = 1e-11  # rad, rad/s after 300 steps; measured 4e-13 of our own, 1e-14 of the engines
CONSERVED = 1e-13  # share of the angular momentum, which the reference keeps in world axes; measured 1e-15
TENDONS = 1e-10  # rad, rad/s: MuJoCo's own Runge-Kutta at 0.5 ms; measured 2e-12


@pytest.fixture
def robot(offset_robot):
    """Centre of mass off every axis, all products of inertia."""
    return dataclasses.replace(offset_robot, dof=BALL)


def loads(robot):
    """A state on the move, commands and a wrench whose force has no effect."""
    rng = np.random.default_rng(12)
    return samples.spherical_state(rng, speed=2.0), rng.uniform(20, 150, robot.m), 30.0 * rng.normal(size=6)


def about_origin(robot):
    """Inertia about the origin, platform axes: of the tensor's point masses, each moved by the centre of mass."""
    c = robot.platform.center_of_mass
    shift = np.cross(np.eye(3), c)
    return robot.platform.inertia + robot.platform.mass * shift @ shift.T


def euler(robot, start, seconds, command, external):
    """Rotation matrix and angular velocity in body axes by DOP853: R' = R [w x], J w' = M + c x m R^T g - w x J w."""
    A, B, p = robot.anchors[:, :3], robot.anchors[:, 3:], start[:3]
    c, m, J = robot.platform.center_of_mass.copy(), robot.platform.mass, about_origin(robot)

    def slope(_, y):
        R, w = y[:9].reshape(3, 3), y[9:]
        line = (A - p) @ R - B  # body axes
        pull = command[:, None] * line / np.linalg.norm(line, axis=1)[:, None]
        moment = np.cross(B, pull).sum(axis=0) + R.T @ external[3:] + np.cross(c, m * R.T @ GRAVITY)
        turn = R @ np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        return np.concatenate([turn.ravel(), np.linalg.solve(J, moment - np.cross(w, J @ w))])

    R = rotations.matrix(start[3:7])
    y0 = np.concatenate([R.ravel(), R.T @ start[10:]])
    y = solve_ivp(slope, (0, seconds), y0, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    R = y[:9].reshape(3, 3)
    return R, R @ y[9:]


def travel(name, robot, start, command, external, seconds, step, **options):
    """The state after some time."""
    backend = plant(name, robot, gravity=GRAVITY, step=step, **options)
    backend.reset(start)
    backend.command[:], backend.external[:] = command, external
    backend.step(round(seconds / step))
    end = backend.state.copy()
    backend.close()
    return end


def errors(state, truth):
    """Of rotation matrix and angular velocity."""
    R, w = truth
    return max(np.abs(rotations.matrix(state[3:7]) - R).max(), np.abs(state[10:] - w).max())


def test_reference_is_euler_and_of_order_four(robot):
    start, command, external = loads(robot)
    truth = euler(robot, start, 0.3, command, external)
    assert errors(travel("reference", robot, start, command, external, 0.3, 5e-4), truth) < EXACT
    steps = np.array([0.02, 0.01, 0.005])
    found = [errors(travel("reference", robot, start, command, external, 0.3, step), truth) for step in steps]
    assert np.polyfit(np.log(steps), np.log(found), 1)[0] == pytest.approx(4.0, abs=0.2)


@pytest.mark.skipif("mujoco" not in ENGINES, reason="mujoco is not installed")
def test_tendons_with_runge_kutta_are_euler(robot):
    """A moment held in world axes over the stages."""
    start, command, external = loads(robot)
    options = {"cables": "native", "integrator": "rk4"}
    end = travel("mujoco", robot, start, command, external, 0.3, 5e-4, **options)
    assert errors(end, euler(robot, start, 0.3, command, external)) < TENDONS


@pytest.mark.parametrize("name", ["semi_implicit_euler", *ENGINES])
def test_engines_are_semi_implicit_euler(robot, name):
    start, command, external = loads(robot)
    own, options = ("reference", {"scheme": name}) if name not in ENGINES else (name, {})
    end = travel(own, robot, start, command, external, 0.3, 1e-3, **options)
    twin = oracle(robot, GRAVITY, 1e-3)
    twin.reset(start)
    twin.command[:], twin.external[:] = command, external
    twin.step(300)
    assert samples.distance(end, twin.state) < SAME_SCHEME
    assert samples.distance(end, travel("reference", robot, start, command, external, 0.3, 1e-3)) > 1e6 * SAME_SCHEME


@pytest.mark.parametrize("name", ALL)
def test_the_origin_stays_to_the_bit_and_its_force_does_nothing(robot, name):
    """Also if a requested state moves it, as an inner step of a search may."""
    start, command, external = loads(robot)
    moving = start.copy()
    moving[7:10] = [0.3, -0.2, 0.1]
    end = travel(name, robot, moving, command, external, 0.1, 1e-3)
    np.testing.assert_array_equal(end[:3], start[:3])
    np.testing.assert_array_equal(end[7:10], 0.0)
    pushed = external + np.array([500.0, -3000.0, 900.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(end, travel(name, robot, start, command, pushed, 0.1, 1e-3), rtol=0, atol=1e-13)


def test_a_torque_free_platform_keeps_its_angular_momentum(robot):
    """Its centre of mass circles round the ball."""
    start, _, _ = loads(robot)
    backend = plant("reference", robot, gravity=np.zeros(3))
    backend.reset(start)

    def invariants():
        R = rotations.matrix(backend.state[3:7])
        L = R @ about_origin(robot) @ R.T @ backend.state[10:]
        return L, 0.5 * L @ backend.state[10:]

    L, kinetic = invariants()
    backend.step(5000)
    late, kept = invariants()
    assert np.abs(late - L).max() < CONSERVED * np.linalg.norm(L)
    assert kept == pytest.approx(kinetic, rel=1e-10)  # of order four; measured 1e-12
    assert kinetic == pytest.approx(energy(robot.inertial, np.zeros(3), start)[0], rel=1e-12)


def test_a_top_keeps_energy_and_two_momenta(robot):
    """Lagrange's top: two equal moments and the centre of mass on the third axis, under gravity alone."""
    platform = dataclasses.replace(
        robot.platform, inertia=frozen_array(np.diag([2.0, 2.0, 1.5])), center_of_mass=frozen_array([0.0, 0.0, 0.2])
    )
    top = dataclasses.replace(robot, platform=platform)
    start = np.concatenate([[0, 0, 2], rotations.from_rpy(0.4, 0.2, 0.0), np.zeros(3), [0.5, 1.0, 20.0]])

    def invariants(state):
        R = rotations.matrix(state[3:7])
        L = R @ about_origin(top) @ R.T @ state[10:]
        return [sum(energy(top.inertial, GRAVITY, state)), L[2], L @ R[:, 2]]

    backend = plant("reference", top)
    backend.reset(start)
    backend.step(2000)
    assert rotations.matrix(backend.state[3:7])[2, 2] < 0.99  # it precesses
    np.testing.assert_allclose(invariants(backend.state), invariants(start), rtol=1e-8)  # of order four; measured 2e-9


@pytest.mark.parametrize("name", ALL)
def test_a_snapshot_brings_it_back(robot, name):
    start, command, external = loads(robot)
    backend = plant(name, robot)
    backend.reset(start)
    backend.command[:], backend.external[:] = command, external
    backend.step(30)
    saved = backend.snapshot()
    backend.step(60)
    first = backend.state.copy()
    elsewhere = start + np.concatenate([[1.0, 2.0, 3.0], np.zeros(10)])
    backend.reset(elsewhere)
    backend.step(5)
    backend.restore(saved)
    backend.step(60)
    np.testing.assert_allclose(backend.state, first, rtol=0, atol=1e-14)
    backend.close()
