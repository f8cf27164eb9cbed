"""Robots on winches in plain numpy, from the equations alone; shares no code with the kernels.

Newton and Euler about the origin, the points where cables are fixed by their own accelerations, and, with rigid cables,
all tensions and accelerations from one linear system, without reflected inertia.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from conftest import GRAVITY
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from cdpr.model import Winch

WINCH = Winch(drum_radius=0.04, inertia=3e-3, viscous_friction=0.02, coulomb_friction=0.05, coulomb_speed=0.5)
SMOOTH = Winch(drum_radius=0.04, inertia=3e-3)
HELD = Winch(drum_radius=0.04, inertia=1e9)  # so heavy that it does not turn


def cross(a, b):
    """As numpy's, in a fifth of the time; vectors, or rows of them."""
    return a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]]


def on_winches(robot, model, *, stiffness=1e5, damping=50.0, winch=WINCH):
    """The robot with the same winch and cable everywhere, but no two quite alike; if mixed, of different models."""
    models = ["rigid", "elastic", "elastic", "ideal"] if model == "mixed" else [None]
    cables = tuple(
        replace(
            cable,
            winch=replace(winch, inertia=winch.inertia * (1 + 0.1 * i)),
            axial_stiffness=stiffness * (1 + 0.05 * i),
            damping=damping,
            model=models[i % len(models)],
        )
        for i, cable in enumerate(robot.cables)
    )
    return replace(robot, cables=cables, cable_model="ideal" if model == "mixed" else model)


class Oracle:
    """Equations of one robot under held commands (m,) and external wrench (6,)."""

    def __init__(self, robot, command, external=None, gravity=GRAVITY):
        self.robot, self.command, self.gravity = robot, np.array(command), np.array(gravity)
        self.external = np.zeros(6) if external is None else np.array(external)
        winches = [cable.winch for cable in robot.cables]
        self.r = np.array([winch.drum_radius for winch in winches])
        self.inertia = np.array([winch.inertia for winch in winches])
        self.b = np.array([winch.viscous_friction for winch in winches])
        self.c = np.array([winch.coulomb_friction for winch in winches])
        self.knee = np.array([winch.coulomb_speed for winch in winches])
        self.EA = np.array([cable.axial_stiffness for cable in robot.cables])
        self.d = np.array([cable.damping for cable in robot.cables])
        self.models = np.array([cable.model or robot.cable_model for cable in robot.cables])
        self.elastic = self.models == "elastic"

    def friction(self, w):
        return self.b * w + self.c * np.tanh(w / self.knee)

    def geometry(self, y):
        """Arms, unit vectors, lengths, rates, and l'' while the platform does not accelerate."""
        R = Rotation.from_quat(y[3:7], scalar_first=True)
        v, omega = y[7:10], y[10:13]
        arms = R.apply(self.robot.anchors[:, 3:].copy())
        line = self.robot.anchors[:, :3] - y[:3] - arms
        l = np.linalg.norm(line, axis=1)  # noqa: E741
        u = line / l[:, None]
        speed = -(v + cross(omega, arms))
        rate = np.sum(u * speed, axis=1)
        swing = (np.sum(speed**2, axis=1) - rate**2) / l - np.sum(u * cross(omega, cross(omega, arms)), axis=1)
        return arms, u, l, rate, swing

    def dynamics(self, y):
        """M (6, 6) and h (6,) of M [a; alpha] = [force; moment about the origin] + h."""
        platform = self.robot.platform
        R = Rotation.from_quat(y[3:7], scalar_first=True).as_matrix()
        c, omega, m = R @ platform.center_of_mass, y[10:13], platform.mass
        inertia = R @ platform.inertia @ R.T
        S = cross(c, np.eye(3)).T  # c x
        M = np.block([[m * np.eye(3), -m * S], [m * S, inertia - m * S @ S]])
        force = m * self.gravity - m * cross(omega, cross(omega, c))
        return M, np.concatenate([force, cross(c, force) - cross(omega, inertia @ omega)])

    def given(self, y):
        """Tensions (m,) that do not depend on the acceleration, NaN for rigid cables."""
        m = self.robot.m
        tension = np.where(self.models == "ideal", self.command, np.nan)
        if self.elastic.any():
            _, _, l, rate, _ = self.geometry(y)  # noqa: E741
            l0, w = np.where(self.elastic, y[13 : 13 + m], 1.0), y[13 + m : 13 + 2 * m]
            pull = np.maximum(0.0, self.EA * (l - l0) / l0 + self.d * (rate + self.r * w))
            tension[self.elastic] = np.where(l > l0, pull, 0.0)[self.elastic]
        return tension

    def solve(self, y, given=None):
        """Acceleration (6,), zero where a guide holds, and tensions (m,), unless these are given."""
        arms, u, _, rate, swing = self.geometry(y)
        W = np.vstack([u.T, cross(arms, u).T])
        M, h = self.dynamics(y)
        rows, m = self.robot.rows, self.robot.m
        load, M, W = (self.external + h)[rows], M[np.ix_(rows, rows)], W[rows]
        acceleration, given = np.zeros(6), self.given(y) if given is None else given
        known = ~np.isnan(given)
        if known.all():
            acceleration[rows] = np.linalg.solve(M, W @ given + load)
            return acceleration, given
        pulls = np.ones(m, dtype=bool)
        for _ in range(2 * m):
            # M a - W T = load;  T - (I / r^2) l'' = u - f / r,  l'' = swing - W^T a;  T = 0 where slack
            ratio = np.where(known, 0.0, self.inertia / self.r**2)
            A = np.block([[M, -W], [ratio[:, None] * W.T, np.eye(m)]])
            drums = self.command - self.friction(-rate / self.r) / self.r + ratio * swing
            right = np.concatenate([load, np.where(known, given, drums)])
            would = A[len(rows) :, : len(rows)], right[len(rows) :]
            A[len(rows) :, : len(rows)][~pulls] = 0.0
            right[len(rows) :][~pulls] = 0.0
            both = np.linalg.solve(A, right)
            tight = known | (would[1] - would[0] @ both[: len(rows)] >= 0.0)
            if np.array_equal(tight, pulls):
                break
            pulls = tight
        acceleration[rows] = both[: len(rows)]
        return acceleration, both[len(rows) :]

    def tension(self, y):
        """Tensions (m,) at y: state (13,), with elastic cables then unstretched lengths and drum speeds."""
        return self.solve(y)[1]

    def start(self, state):
        """The state with the winches as they start."""
        if not self.elastic.any():
            return np.array(state)
        _, _, l, rate, _ = self.geometry(state)  # noqa: E741
        own = np.array([l / (1 + self.command / self.EA), -rate / self.r])
        return np.concatenate([state, *np.where(self.elastic, own, 0.0)])

    def slope(self, _, y):
        y = np.array(y)
        y[3:7] /= np.linalg.norm(y[3:7])
        acceleration, tension = self.solve(y)
        w, (a, x, yy, z) = y[10:13], y[3:7]
        turn = 0.5 * np.array(
            [
                -w[0] * x - w[1] * yy - w[2] * z,
                w[0] * a + w[1] * z - w[2] * yy,
                w[1] * a + w[2] * x - w[0] * z,
                w[2] * a + w[0] * yy - w[1] * x,
            ]
        )
        body = np.concatenate([y[7:10], turn, acceleration])
        if not self.elastic.any():
            return body
        speed = y[13 + self.robot.m :]
        drum = (self.r * (self.command - tension) - self.friction(speed)) / self.inertia
        return np.concatenate([body, *np.where(self.elastic, [-self.r * speed, drum], 0.0)])

    def exact(self, state, seconds, tolerance=1e-12):
        """Return the state after some time, by an integrator of order eight, with the tolerance of a step."""
        start, both = self.start(state), {"rtol": tolerance, "atol": tolerance}
        y = solve_ivp(self.slope, (0, seconds), start, method="DOP853", **both).y[:, -1]
        y[3:7] /= np.linalg.norm(y[3:7])
        return y

    def semi_implicit(self, state, h, n):
        """The same by semi-implicit Euler, the platform by its centre of mass, on a guide by its origin."""
        y, m = self.start(state), self.robot.m
        center = self.robot.platform.center_of_mass.copy() if self.robot.n == 6 else np.zeros(3)
        for _ in range(n):
            acceleration, tension = self.solve(y)
            R = Rotation.from_quat(y[3:7], scalar_first=True)
            r, omega = R.apply(center), y[10:13]
            speed = y[7:10] + cross(omega, r)
            pull = acceleration[:3] + cross(acceleration[3:], r) + cross(omega, cross(omega, r))
            body_rate = R.inv().apply(omega) + h * R.inv().apply(acceleration[3:])
            place = y[:3] + r + h * (speed + h * pull)
            turned = R * Rotation.from_rotvec(h * body_rate)
            omega = turned.apply(body_rate)
            y[:3] = place - turned.apply(center)
            y[3:7] = turned.as_quat(scalar_first=True)
            y[7:10] = speed + h * pull - cross(omega, turned.apply(center))
            y[10:13] = omega
            if self.elastic.any():
                w = y[13 + m :]
                w += np.where(
                    self.elastic, h * (self.r * (self.command - tension) - self.friction(w)) / self.inertia, 0.0
                )
                y[13 : 13 + m] -= h * self.r * w
        return y
