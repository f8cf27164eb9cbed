"""A plant in plain numpy, written from the equations alone: semi-implicit Euler with the cables at each step.

It shares no code with the kernels. Free: w += h I^-1 (M - w x I w) in body axes, q <- q exp(h w), v += h F / m + h g,
x += h v, for the centre of mass. On a guide: u += h u', q += h u for the coordinates q. On a ball: the free body's
turning, about the origin.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from cdpr.plugins import Backend


def oracle(robot, gravity, physics_step, options=None):
    """The one for a free or a guided platform; looks like a `cdpr.plugins.Backend`."""
    kind = SphericalSemiImplicitEuler if robot.pattern == "3R" else GuidedSemiImplicitEuler
    return (SemiImplicitEuler if robot.n == 6 else kind)(robot, gravity, physics_step)


def exit_points(robot, A, tips):
    """Return the exit points of the cables: anchors A, or contact points of the tangents to swivelling pulleys."""
    points = A.copy()
    for i, cable in enumerate(robot.cables):
        if cable.exit is not None:
            along = np.array(cable.exit.axis) / np.linalg.norm(cable.exit.axis)
            away = np.cross(np.cross(along, tips[i] - A[i]), along)
            away /= np.linalg.norm(away)
            reach = tips[i] - A[i] - cable.exit.radius * away
            angle = np.arctan2(reach @ along, reach @ away) + np.arccos(cable.exit.radius / np.linalg.norm(reach))
            points[i] += cable.exit.radius * (away + np.cos(angle) * away + np.sin(angle) * along)
    return points


class SemiImplicitEuler(Backend):
    """A free platform."""

    def __init__(self, robot, gravity, physics_step, options=None):
        super().__init__(robot, gravity, physics_step, options)
        self.h = physics_step

    def reset(self, state):
        self.state[:] = state

    def wrench(self, p, R):
        """Force and moment about the origin, world axes."""
        anchors = self.robot.anchors.copy()
        A, B = anchors[:, :3], anchors[:, 3:]
        arms = R.apply(B)
        lines = exit_points(self.robot, A, p + arms) - p - arms
        pulls = self.command[:, None] * lines / np.linalg.norm(lines, axis=1)[:, None]
        return pulls.sum(axis=0) + self.external[:3], np.cross(arms, pulls).sum(axis=0) + self.external[3:]

    def step(self, n):
        platform = self.robot.platform
        c, m, inertia = platform.center_of_mass.copy(), platform.mass, platform.inertia
        p, v, omega = self.state[:3].copy(), self.state[7:10].copy(), self.state[10:].copy()
        R = Rotation.from_quat(self.state[3:7], scalar_first=True)
        x, v = p + R.apply(c), v + np.cross(omega, R.apply(c))
        w = R.inv().apply(omega)
        for _ in range(n):
            p = x - R.apply(c)
            force, moment = self.wrench(p, R)
            moment = R.inv().apply(moment - np.cross(R.apply(c), force))
            w = w + self.h * np.linalg.solve(inertia, moment - np.cross(w, inertia @ w))
            R = R * Rotation.from_rotvec(self.h * w)
            v = v + self.h * (force / m + self.gravity)
            x = x + self.h * v
        omega = R.apply(w)
        self.state[:3] = x - R.apply(c)
        self.state[3:7] = R.as_quat(scalar_first=True)
        self.state[7:10] = v - np.cross(omega, R.apply(c))
        self.state[10:] = omega


class GuidedSemiImplicitEuler(SemiImplicitEuler):
    """A platform on a guide: Lagrange's equations M u' = Q - m J^T J' u in the coordinates of the robot's dof.

    J, 3 x n, takes their rates u to the velocity of the centre of mass.
    """

    def step(self, n):
        platform, rows = self.robot.platform, self.robot.rows
        hinge = next((row - 3 for row in rows if row >= 3), None)
        p, u = self.state[:3].copy(), self.state[7:][rows]
        axis = np.zeros(3) if hinge is None else np.eye(3)[hinge]
        turn = Rotation.from_quat(self.state[3:7], scalar_first=True).as_rotvec() @ axis
        for _ in range(n):
            R = Rotation.from_rotvec(turn * axis)
            c, spin = R.apply(platform.center_of_mass.copy()), 0.0 if hinge is None else u[-1]
            J = np.hstack([np.eye(3), np.cross(np.eye(3), c).T])[:, rows]
            M = platform.mass * J.T @ J
            if hinge is not None:
                M[-1, -1] += axis @ platform.inertia @ axis
            centripetal = np.cross(spin * axis, np.cross(spin * axis, c))
            wrench = np.concatenate(self.wrench(p, R))
            Q = wrench[rows] + platform.mass * J.T @ (self.gravity - centripetal)
            u = u + self.h * np.linalg.solve(M, Q)
            for rate, row in zip(u, rows, strict=True):
                if row < 3:
                    p[row] += self.h * rate
                else:
                    turn += self.h * rate
        self.state[:3] = p
        self.state[3:7] = Rotation.from_rotvec(turn * axis).as_quat(scalar_first=True)
        self.state[7:] = 0.0
        for rate, row in zip(u, rows, strict=True):
            self.state[7 + row] = rate


class SphericalSemiImplicitEuler(SemiImplicitEuler):
    """A platform on a ball at its origin: Euler's equations with the inertia about it, by Steiner."""

    def step(self, n):
        platform = self.robot.platform
        c, m = platform.center_of_mass.copy(), platform.mass
        inertia = platform.inertia + m * (c @ c * np.eye(3) - np.outer(c, c))
        R = Rotation.from_quat(self.state[3:7], scalar_first=True)
        w = R.inv().apply(self.state[10:])
        for _ in range(n):
            moment = R.inv().apply(self.wrench(self.state[:3], R)[1]) + np.cross(c, m * R.inv().apply(self.gravity))
            w = w + self.h * np.linalg.solve(inertia, moment - np.cross(w, inertia @ w))
            R = R * Rotation.from_rotvec(self.h * w)
        self.state[3:7], self.state[7:10], self.state[10:] = R.as_quat(scalar_first=True), 0.0, R.apply(w)
