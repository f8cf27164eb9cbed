"""The reference backend: order four, energy and momentum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import GRAVITY, crossed_box, make_robot, random_state
from oracle import exit_points
from scipy.integrate import solve_ivp

from cdpr.cables import Pulley
from cdpr.model import rotations
from cdpr_backends.reference import ReferenceBackend

pytestmark = pytest.mark.core

ENERGY = 1e-9  # relative drift over 10 s, measured 3e-13
MOMENTUM = 1e-11  # relative drift over 10 s
EXACT = 1e-9  # of an adaptive integrator of order eight at its tightest


def travel(robot, start, step, seconds, *, gravity=GRAVITY, command=None, external=None):
    backend = ReferenceBackend(robot, gravity, step, None)
    backend.reset(start)
    backend.command[:] = 0.0 if command is None else command
    backend.external[:] = 0.0 if external is None else external
    backend.step(round(seconds / step))
    return backend.state.copy()


def distance(a, b):
    turn = rotations.rotation_vector(rotations.multiply(a[3:7], rotations.conjugate(b[3:7])))
    return float(np.linalg.norm(np.concatenate([a[:3] - b[:3], turn, a[7:] - b[7:]])))


def exact(robot, start, seconds, command, external):
    """The same motion by scipy's DOP853 from the Newton-Euler equations about the origin."""
    platform = robot.platform
    c, m, inertia = platform.center_of_mass, platform.mass, platform.inertia
    A, B = robot.anchors[:, :3], robot.anchors[:, 3:]

    def slope(_, y):
        q = y[3:7] / np.linalg.norm(y[3:7])
        R = rotations.matrix(q)
        omega = y[10:]
        r, arms = R @ c, B @ R.T
        lines = exit_points(robot, A, y[:3] + arms) - y[:3] - arms
        pulls = command[:, None] * lines / np.linalg.norm(lines, axis=1)[:, None]
        force = pulls.sum(axis=0) + external[:3]
        moment = np.cross(arms, pulls).sum(axis=0) + external[3:] - np.cross(r, force)
        world = R @ inertia @ R.T
        alpha = np.linalg.solve(world, moment - np.cross(omega, world @ omega))
        a = force / m + GRAVITY - np.cross(alpha, r) - np.cross(omega, np.cross(omega, r))
        spin = 0.5 * rotations.multiply(np.concatenate([[0.0], omega]), y[3:7])
        return np.concatenate([y[7:10], spin, a, alpha])

    end = solve_ivp(slope, (0, seconds), start, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    end[3:7] /= np.linalg.norm(end[3:7])
    return end


def over_pulleys(robot):
    """The robot with pulleys that come from different sides, but for one cable."""
    axes = np.random.default_rng(4).normal(size=(robot.m - 1, 3))
    exits = [None, *(Pulley(radius=0.1, axis=tuple(axis)) for axis in axes.tolist())]
    return replace(robot, cables=tuple(map(lambda cable, own: replace(cable, exit=own), robot.cables, exits)))


@pytest.mark.parametrize("pulleys", [False, True])
def test_held_commands_as_an_independent_integrator(offset_robot, pulleys):
    """Cables, gravity, an external wrench and a centre of mass off the origin, by other equations."""
    rng = np.random.default_rng(3)
    robot = over_pulleys(offset_robot) if pulleys else offset_robot
    start, command, external = random_state(rng), rng.uniform(20, 120, 8), rng.normal(size=6) * 30
    ours = travel(robot, start, 1e-3, 0.4, command=command, external=external)
    assert distance(ours, exact(robot, start, 0.4, command, external)) < EXACT


@pytest.mark.parametrize("pulleys", [False, True])
@pytest.mark.parametrize("held", [True, False])
def test_order_is_four(offset_robot, held, pulleys):
    offset_robot = over_pulleys(offset_robot) if pulleys else offset_robot
    rng = np.random.default_rng(5)
    start = random_state(rng)
    command = rng.uniform(20, 120, 8) if held else None
    gravity = GRAVITY if held else np.zeros(3)
    steps = np.array([0.02, 0.01, 0.005])
    truth = travel(offset_robot, start, 0.0005, 0.4, gravity=gravity, command=command)
    errors = [distance(travel(offset_robot, start, h, 0.4, gravity=gravity, command=command), truth) for h in steps]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert order == pytest.approx(4.0, abs=0.2)


def test_torque_free_spin_keeps_energy_and_momentum(offset_robot):
    start = np.concatenate([[0, 0, 2], rotations.from_rpy(0.3, 0.2, 0.1), [0.3, -0.2, 0.1], [0.2, 3.0, 0.1]])
    end = travel(offset_robot, start, 1e-3, 10.0, gravity=np.zeros(3))
    platform = offset_robot.platform

    def invariants(state):
        R = rotations.matrix(state[3:7])
        v = state[7:10] + np.cross(state[10:], R @ platform.center_of_mass)
        L = R @ platform.inertia @ R.T @ state[10:]
        return 0.5 * platform.mass * v @ v + 0.5 * L @ state[10:], platform.mass * v, L

    (energy0, p0, L0), (energy1, p1, L1) = invariants(start), invariants(end)
    assert abs(energy1 - energy0) <= ENERGY * energy0
    assert np.linalg.norm(p1 - p0) <= MOMENTUM * np.linalg.norm(p0)
    assert np.linalg.norm(L1 - L0) <= MOMENTUM * np.linalg.norm(L0)
    assert abs(np.linalg.norm(end[3:7]) - 1.0) < 1e-15


def test_free_fall_is_exact():
    robot = make_robot(crossed_box(np.random.default_rng(0), 8))
    start = np.concatenate([[0, 0, 2], [1, 0, 0, 0], [1.0, 0, 3.0], np.zeros(3)])
    end = travel(robot, start, 1e-3, 1.0)
    np.testing.assert_allclose(end[:3], [1.0, 0.0, 2 + 3 - 9.81 / 2], atol=1e-12)


def test_pieces_are_the_whole(offset_robot):
    rng = np.random.default_rng(9)
    start, command = random_state(rng), rng.uniform(20, 120, 8)
    whole = travel(offset_robot, start, 1e-3, 0.1, command=command)
    backend = ReferenceBackend(offset_robot, GRAVITY, 1e-3, None)
    backend.reset(start)
    backend.command[:] = command
    for n in (1, 9, 40, 50):
        backend.step(n)
    np.testing.assert_array_equal(backend.state, whole)
