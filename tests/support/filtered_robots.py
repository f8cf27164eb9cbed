"""Robots in plain numpy with white noise on platform and measurements, many at once; shares no code with the filter.

Newton and Euler about the origin in the axes of the platform, by the method of Runge and Kutta of fourth order, with
tensions and a random wrench held over each control step. Cables leave points or swivelling pulleys; those that stretch
hang on drums with inertia.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from scipy.spatial.transform import Rotation

from cdpr.plugins import EstimatorInputs, SensorModel
from cdpr.sensing import Encoders
from cdpr_controllers.estimators import EkfOptions
from cdpr_controllers.estimators.ekf import Ekf

GRAVITY = np.array([0.0, 0.0, -9.81])  # m/s^2
STEP = 1e-3  # s, of control
NOISE = 5e-4  # m, of the encoders
START = {"position_error": 2e-3, "rotation_error": 4e-3, "velocity_error": 0.02, "turn_rate_error": 0.04}


def skew(v):
    """Matrices (..., 3, 3) with skew(v) @ x = v x x."""
    return np.cross(v[..., None, :], np.eye(3)).swapaxes(-1, -2) * -1.0 @ -np.eye(3)


class Truth:
    """Robots in N states at once, under tensions as sent.

    Args:
        robot: a robot; its cables are ideal, or elastic on drums with inertia.
        state: positions (N, 3), `Rotation` of N, velocities (N, 3), angular velocities (N, 3), world axes.
        tension: (N, m), N, with which cables that stretch start.
    """

    def __init__(self, robot, state, tension):
        self.robot = robot
        self.place, self.turn, self.velocity, self.spin = state
        self.A, self.B = robot.anchors[:, :3], robot.anchors[:, 3:]
        self.mass, self.c = robot.inertial[0], robot.inertial[1:4]
        self.free = np.zeros(6)
        self.free[robot.rows] = 1.0
        lever = np.array([np.cross(self.c, e) for e in np.eye(3)]).T  # lever @ x = c x x
        inertia = robot.inertial[4:].reshape(3, 3) - self.mass * lever @ lever
        self.M = np.block([[self.mass * np.eye(3), -self.mass * lever], [self.mass * lever, inertia]])
        exits = [cable.exit for cable in robot.cables]
        self.radius = np.array([0.0 if each is None else getattr(each, "radius", 0.0) for each in exits])
        self.elastic = robot.cable_model == "elastic"
        if self.elastic:
            self.EA = np.array([cable.axial_stiffness for cable in robot.cables])
            self.damping = np.array([cable.damping for cable in robot.cables])
            self.r = np.array([cable.winch.drum_radius for cable in robot.cables])
            self.I = np.array([cable.winch.inertia for cable in robot.cables])
            length, _, rate = self.cables(self.place, self.turn, self.velocity, self.spin)
            self.unwound, self.unwinding = length / (1.0 + tension / self.EA), rate
        else:
            self.unwound = self.unwinding = np.zeros((len(self.place), robot.m))

    def cables(self, place, turn, velocity, spin):
        """Lengths (N, m), wrench matrices (N, 6, m) and rates of the lengths (N, m)."""
        b = np.einsum("nij,mj->nmi", turn.as_matrix(), self.B)
        tip = place[:, None] + b
        away = tip - self.A
        out = np.hypot(away[..., 0], away[..., 1])  # from the vertical on which a cable arrives
        r = self.radius
        c, z = out - r, away[..., 2]
        free = np.sqrt(c**2 + z**2 - r**2)
        wrap = np.arctan2(free * c + r * z, free * z - r * c) % (2.0 * np.pi)
        along = away[..., :2] / out[..., None]
        exit_ = self.A + np.concatenate(
            [(r * (1.0 - np.cos(wrap)))[..., None] * along, (r * np.sin(wrap))[..., None]], axis=-1
        )
        span = np.where(r[:, None] > 0.0, exit_, self.A) - tip
        norm = np.linalg.norm(span, axis=-1)
        u = span / norm[..., None]
        W = np.concatenate([u, np.cross(b, u)], axis=-1).swapaxes(1, 2)
        length = norm + np.where(r > 0.0, r * wrap, 0.0)
        return length, W, -np.einsum("nij,ni->nj", W, np.concatenate([velocity, spin], axis=1))

    def slopes(self, place, turn, velocity, spin, unwound, unwinding, command, push):
        """Accelerations of the platform (N, 6), world axes, and of the unwound lengths (N, m)."""
        length, W, rate = self.cables(place, turn, velocity, spin)
        tension, winding = command, np.zeros_like(command)
        if self.elastic:
            tension = self.EA * (length / unwound - 1.0) + self.damping * (rate - unwinding)
            winding = -(self.r**2) * (command - tension) / self.I
        R = turn.as_matrix()
        omega = np.einsum("nji,nj->ni", R, spin)
        weight = self.mass * GRAVITY @ R
        wrench = np.einsum("nij,nj->ni", W, tension) + push
        bias = np.concatenate(
            [self.mass * np.cross(omega, np.cross(omega, self.c)), np.cross(omega, omega @ self.J().T)], axis=1
        )
        own = np.concatenate([np.einsum("nji,nj->ni", R, wrench[:, :3]), np.einsum("nji,nj->ni", R, wrench[:, 3:])], 1)
        own += np.concatenate([weight, np.cross(self.c, weight)], axis=1) - bias
        if self.free.all():
            found = np.linalg.solve(self.M, own.T).T
            return np.concatenate(
                [np.einsum("nij,nj->ni", R, found[:, :3]), np.einsum("nij,nj->ni", R, found[:, 3:])], 1
            ), winding
        both = np.kron(np.eye(2), np.ones((3, 3))) * np.tile(R, (1, 2, 2))
        M = (both @ self.M @ both.swapaxes(1, 2))[:, self.free == 1.0][:, :, self.free == 1.0]
        found = np.zeros((len(place), 6))
        force = np.einsum("nij,nj->ni", both, own)[:, self.free == 1.0]
        found[:, self.free == 1.0] = np.linalg.solve(M, force[..., None])[..., 0]
        return found, winding

    def J(self):
        """Inertia about the origin (3, 3), platform axes."""
        return self.M[3:, 3:]

    def advance(self, command, push):
        """Move on by a control step under these commands (N, m), N, and wrenches (N, 6)."""
        count = 4 if self.elastic else 1
        for _ in range(count):
            self._advance(command, push, STEP / count)

    def _advance(self, command, push, h):
        start = self.place, self.turn, self.velocity, self.spin, self.unwound, self.unwinding
        total = [0.0] * 5
        place, turn, velocity, spin, unwound, unwinding = start
        weights = (1.0, 2.0, 2.0, 1.0)
        rotation = np.zeros_like(spin)  # of this step so far, world axes
        for k, weight in enumerate(weights):
            acceleration, winding = self.slopes(place, turn, velocity, spin, unwound, unwinding, command, push)
            turning = spin - 0.5 * np.cross(rotation, spin) + np.cross(rotation, np.cross(rotation, spin)) / 12.0
            rates = (velocity, turning, acceleration, unwinding, winding)
            total = [old + weight * new for old, new in zip(total, rates, strict=True)]
            ahead = h * (0.5, 0.5, 1.0, 0.0)[k]
            rotation = ahead * turning
            place, velocity = start[0] + ahead * rates[0], start[2] + ahead * acceleration[:, :3]
            spin, turn = start[3] + ahead * acceleration[:, 3:], Rotation.from_rotvec(rotation) * start[1]
            unwound, unwinding = start[4] + ahead * rates[3], start[5] + ahead * winding
        sixth = h / 6.0
        self.place = start[0] + sixth * total[0]
        self.turn = Rotation.from_rotvec(sixth * total[1]) * start[1]
        self.velocity = start[2] + sixth * total[2][:, :3]
        self.spin = start[3] + sixth * total[2][:, 3:]
        self.unwound, self.unwinding = start[4] + sixth * total[3], start[5] + sixth * total[4]

    def state(self):
        """States (N, 13), in the layout of `cdpr.model`."""
        return np.concatenate([self.place, self.turn.as_quat(scalar_first=True), self.velocity, self.spin], axis=1)
