"""A plant in plain numpy, written from the equations alone: semi-implicit Euler with the cables at each step.

It shares no code with the kernels: w += h I^-1 (M - w x I w) in body axes, q <- q exp(h w), v += h F / m + h g,
x += h v, for the centre of mass.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


class SemiImplicitEuler:
    """Looks like a `cdpr.plugins.Backend`."""

    def __init__(self, robot, gravity, physics_step, options=None):
        self.robot, self.gravity, self.h = robot, np.array(gravity), physics_step
        self.command, self.external, self.state = np.zeros(robot.m), np.zeros(6), np.zeros(13)

    def engine_time(self):
        return None

    def close(self):
        pass

    def reset(self, state):
        self.state[:] = state

    def step(self, n):
        platform = self.robot.platform
        c, m, inertia = platform.center_of_mass.copy(), platform.mass, platform.inertia
        anchors = self.robot.anchors.copy()
        A, B = anchors[:, :3], anchors[:, 3:]
        p, v, omega = self.state[:3].copy(), self.state[7:10].copy(), self.state[10:].copy()
        R = Rotation.from_quat(self.state[3:7], scalar_first=True)
        x, v = p + R.apply(c), v + np.cross(omega, R.apply(c))
        w = R.inv().apply(omega)
        for _ in range(n):
            p = x - R.apply(c)
            arms = R.apply(B)
            lines = A - p - arms
            pulls = self.command[:, None] * lines / np.linalg.norm(lines, axis=1)[:, None]
            force = pulls.sum(axis=0) + self.external[:3]
            moment = np.cross(arms, pulls).sum(axis=0) + self.external[3:] - np.cross(R.apply(c), force)
            moment = R.inv().apply(moment)
            w = w + self.h * np.linalg.solve(inertia, moment - np.cross(w, inertia @ w))
            R = R * Rotation.from_rotvec(self.h * w)
            v = v + self.h * (force / m + self.gravity)
            x = x + self.h * v
        omega = R.apply(w)
        self.state[:3] = x - R.apply(c)
        self.state[3:7] = R.as_quat(scalar_first=True)
        self.state[7:10] = v - np.cross(omega, R.apply(c))
        self.state[10:] = omega
