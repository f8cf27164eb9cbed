"""Guided platforms on the reference backend, against Lagrange's equations and the free body."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from conftest import GRAVITY, ROOT, crossed_box, make_robot
from plants import installed, plant
from scipy.integrate import solve_ivp

from cdpr.mechanics.kinematics import make_state
from cdpr.model import rotations
from cdpr.scenario import load_robot
from cdpr_backends.reference_schemes import make

EXACT = 1e-9  # of an adaptive integrator of order eight at its tightest
ROUND_OFF = 1e-12  # of engines, which multiply what is held by zeros: m, rad and their rates after 300 steps
STEP = 1e-6  # of the differences by which Lagrange's equations are formed
# Of the integration of Lagrange's equations: a hundredth of the bound below. Finer than the noise of the differences it
# would only take smaller and smaller steps.
FINE = 1e-9

DOFS = [("x",), ("x", "z"), ("x", "y", "z"), ("ry",), ("x", "z", "ry"), ("z", "rx"), ("x", "y", "z", "rz")]


def guided(offset_robot, dof):
    return dataclasses.replace(offset_robot, dof=dof)


def start_state(dof):
    p, v, w = np.array([0.1, -0.2, 2.0]), np.zeros(3), np.zeros(3)
    q = np.array([1.0, 0, 0, 0])
    for name in dof:
        if name.startswith("r"):
            axis = "xyz".index(name[1])
            q = rotations.from_axis_angle(np.eye(3)[axis], 0.4)
            w[axis] = 1.5
        else:
            v["xyz".index(name)] = 0.3
    return np.concatenate([p, q, v, w])


def lagrange(robot, start, seconds, command, external):
    """The motion by DOP853 from Lagrange's equations in the guide's coordinates, all derivatives by differences."""
    platform = robot.platform
    A, B = robot.anchors[:, :3], robot.anchors[:, 3:]
    rows = robot.rows
    n = len(rows)

    def pose(c):
        p, angle, axis = start[:3].copy(), 0.0, np.array([0.0, 0.0, 1.0])
        for row, value in zip(rows, c, strict=True):
            if row < 3:
                p[row] += value
            else:
                angle, axis = value, np.eye(3)[row - 3]
        return p, rotations.matrix(rotations.from_axis_angle(axis, angle))

    def twist(c, u):
        full = np.zeros(6)
        full[rows] = u
        _, R = pose(c)
        return full[:3] + np.cross(full[3:], R @ platform.center_of_mass), full[3:], R

    def kinetic(c, u):
        v, w, R = twist(c, u)
        return 0.5 * platform.mass * v @ v + 0.5 * w @ R @ platform.inertia @ R.T @ w

    def force(c):
        """Generalised: of gravity, of the cables as -t dl/dc, and of the external wrench."""
        out = np.empty(n)
        for k in range(n):
            step = np.eye(n)[k] * STEP
            values = []
            for sign in (1, -1):
                p, R = pose(c + sign * step)
                lengths = np.linalg.norm(A - p - B @ R.T, axis=1)
                values.append(platform.mass * GRAVITY @ (p + R @ platform.center_of_mass) - command @ lengths)
            out[k] = (values[0] - values[1]) / (2 * STEP)
        return out + external[rows]

    def slope(_, y):
        c, u = y[:n], y[n:]
        M = np.array([[kinetic(c, a + b) - kinetic(c, a) - kinetic(c, b) for b in np.eye(n)] for a in np.eye(n)])
        momentum = [
            (sum(kinetic(c + s * STEP * u, u + e) - kinetic(c + s * STEP * u, u - e) for s in (1,)) / 2)
            - (kinetic(c - STEP * u, u + e) - kinetic(c - STEP * u, u - e)) / 2
            for e in np.eye(n)
        ]
        drift = np.array(momentum) / (2 * STEP)
        shape = np.array([(kinetic(c + e * STEP, u) - kinetic(c - e * STEP, u)) / (2 * STEP) for e in np.eye(n)])
        return np.concatenate([u, np.linalg.solve(M, force(c) - drift + shape)])

    c0 = np.array([0.4 if row >= 3 else 0.0 for row in rows])
    y0 = np.concatenate([c0, start[7:][rows]])
    y = solve_ivp(slope, (0, seconds), y0, method="DOP853", rtol=FINE, atol=FINE).y[:, -1]
    p, R = pose(y[:n])
    full = np.zeros(6)
    full[rows] = y[n:]
    return p, R, full


@pytest.mark.slow
@pytest.mark.parametrize("dof", DOFS, ids=" ".join)
def test_held_commands_as_lagrange(offset_robot, dof):
    """Cables, gravity, an external wrench, and a centre of mass off every axis."""
    robot = guided(offset_robot, dof)
    rng = np.random.default_rng(3)
    start, command, external = start_state(dof), rng.uniform(20, 120, 8), rng.normal(size=6) * 30
    backend = make(robot, GRAVITY, 1e-3, None)
    backend.reset(start)
    backend.command[:], backend.external[:] = command, external
    backend.step(300)
    p, R, twist = lagrange(robot, start, 0.3, command, external)
    np.testing.assert_allclose(backend.state[:3], p, atol=1e-7)  # the differences' error
    np.testing.assert_allclose(rotations.matrix(backend.state[3:7]), R, atol=1e-7)
    np.testing.assert_allclose(backend.state[7:], twist, atol=1e-6)


@pytest.mark.parametrize("dof", DOFS, ids=" ".join)
def test_order_is_four_and_held_directions_stay(offset_robot, dof):
    robot = guided(offset_robot, dof)
    start, command = start_state(dof), np.random.default_rng(1).uniform(20, 120, 8)

    def travel(step):
        backend = make(robot, GRAVITY, step, None)
        backend.reset(start)
        backend.command[:] = command
        backend.step(round(0.4 / step))
        return backend.state.copy()

    truth = travel(0.0005)
    steps = np.array([0.02, 0.01, 0.005])
    errors = [np.linalg.norm(travel(step) - truth) for step in steps]
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(4.0, abs=0.2)
    held = [row for row in range(6) if row not in robot.rows]
    np.testing.assert_array_equal(truth[7:][held], 0.0)
    np.testing.assert_array_equal(truth[:3][[row for row in held if row < 3]], start[[row for row in held if row < 3]])


@pytest.mark.parametrize("name", ["reference", *installed("mujoco", "bullet", "dart")])
@pytest.mark.parametrize("dof", ["[x, z, ry]", "[ry]", "[x, z]"])
def test_held_moments_have_no_effect(dof, name):
    """Planar robots are published with Izz alone: the motion is that of any robot with the same one."""
    ends = []
    for inertia in ("[0, 0.3, 0, 0, 0, 0]", "[0.5, 0.3, 0.4, 0.05, -0.03, 0.02]"):
        changes = [f"platform.inertia={inertia}", "platform.center_of_mass=[0.03, 0.02, -0.04]", f"dof={dof}"]
        backend = plant(name, load_robot(ROOT / "scenarios" / "robots" / "planar.yaml", overrides=changes))
        backend.reset(make_state([0.1, 0.0, 1.4]))
        backend.command[:], backend.external[:] = [300.0, 350.0, 50.0, 60.0], [5.0, 900.0, -3.0, 70.0, 2.0, -90.0]
        backend.step(300)
        ends.append(backend.state.copy())
        backend.close()
    assert np.abs(ends[0] - make_state([0.1, 0.0, 1.4])).max() > 0.1
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=0.0 if name == "reference" else ROUND_OFF)


def test_a_guided_point_mass_falls_as_a_free_one():
    robot = make_robot(crossed_box(np.random.default_rng(0), 8))
    start = np.concatenate([[0, 0, 2], [1, 0, 0, 0], np.zeros(6)])
    states = []
    for dof in (robot.dof, ("x", "y", "z")):
        backend = make(dataclasses.replace(robot, dof=dof), GRAVITY, 1e-3, None)
        backend.reset(start)
        backend.step(1000)
        states.append(backend.state.copy())
    np.testing.assert_allclose(states[0], states[1], atol=1e-12)
