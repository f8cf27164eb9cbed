"""Robots in plain numpy with white noise on platform and measurements, many at once; shares no code with the filter.

Newton and Euler about the origin in the axes of the platform, by the method of Runge and Kutta of fourth order, with
tensions and a random wrench held over each control step. Cables leave points or swivelling pulleys; those that stretch
hang on drums with inertia and friction.
"""

from __future__ import annotations

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


class Truth:
    """Robots in N states at once, under tensions as sent.

    Args:
        robot: a robot; its cables are ideal, or elastic on drums with inertia and friction.
        state: positions (N, 3), `Rotation` of N, velocities (N, 3), angular velocities (N, 3), world axes.
    """

    def __init__(self, robot, state):
        self.place, self.turn, self.velocity, self.spin = state
        self.A, self.B = robot.anchors[:, :3], robot.anchors[:, 3:]
        self.mass, self.c = robot.inertial[0], robot.inertial[1:4]
        self.free = np.zeros(6)
        self.free[robot.rows] = 1.0
        lever = np.array([np.cross(self.c, e) for e in np.eye(3)]).T  # lever @ x = c x x
        self.J = robot.inertial[4:].reshape(3, 3) - self.mass * lever @ lever  # about the origin
        self.M = np.block([[self.mass * np.eye(3), -self.mass * lever], [self.mass * lever, self.J]])
        exits = [cable.exit for cable in robot.cables]
        self.radius = np.array([0.0 if each is None else getattr(each, "radius", 0.0) for each in exits])
        self.elastic = robot.cable_model == "elastic"
        if self.elastic:
            self.EA = np.array([cable.axial_stiffness for cable in robot.cables])
            self.damping = np.array([cable.damping for cable in robot.cables])
            winches = [cable.winch for cable in robot.cables]
            self.r, self.I = (np.array([getattr(each, key) for each in winches]) for key in ("drum_radius", "inertia"))
            self.viscous = np.array([each.viscous_friction for each in winches])
            self.coulomb = np.array([each.coulomb_friction for each in winches])
            self.knee = np.array([each.coulomb_speed for each in winches])
        self.unwound = self.unwinding = np.zeros((len(self.place), robot.m))

    def start(self, tension):
        """Hang the platform on cables with these tensions (N, m), N, which move with it."""
        if self.elastic:
            length, _, rate = self.cables(self.place, self.turn, self.velocity, self.spin)
            self.unwound, self.unwinding = length / (1.0 + tension / self.EA), rate

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
            speed = -unwinding / self.r
            friction = self.viscous * speed + self.coulomb * np.tanh(speed / self.knee)
            winding = -self.r * (self.r * (command - tension) - friction) / self.I
        R = turn.as_matrix()
        omega = np.einsum("nji,nj->ni", R, spin)
        weight = self.mass * GRAVITY @ R
        wrench = np.einsum("nij,nj->ni", W, tension) + push
        bias = np.concatenate(
            [self.mass * np.cross(omega, np.cross(omega, self.c)), np.cross(omega, omega @ self.J)], axis=1
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
        return np.concatenate([self.place, turned(self.turn), self.velocity, self.spin], axis=1)


def turned(turn):
    """Quaternions (N, 4) of rotations."""
    return turn.as_quat(scalar_first=True)


def rotations(quaternions):
    """Rotations of quaternions (N, 4)."""
    return Rotation.from_quat(quaternions, scalar_first=True)


def errors(true, estimated):
    """Errors (N, 12) of estimated states (N, 13): true minus estimated; the attitude's along the platform's axes."""
    turn = (rotations(estimated[:, 3:7]).inv() * rotations(true[:, 3:7])).as_rotvec()
    return np.concatenate([true[:, :3] - estimated[:, :3], turn, true[:, 7:] - estimated[:, 7:]], axis=1)


class Filter:
    """Filter of one run with encoders, and its live inputs."""

    def __init__(self, robot, start, options):
        m = robot.m
        self.sensor = SensorModel(Encoders(length={"noise": NOISE}), np.zeros(2 * m), np.zeros(1), np.ones(1))
        self.estimator = Ekf(robot, GRAVITY, STEP, [self.sensor], EkfOptions(**options))
        self.sent, self.out = np.zeros(m), np.zeros(13)
        none = np.zeros((2, m)), np.zeros(m, dtype=bool)
        self.estimator.connect(EstimatorInputs(np.zeros(1), start, self.sent, ("tension",) * m, self.sent, *none))

    def use(self, time, sent, lengths):
        """Filter a control step."""
        self.sent[:] = sent
        self.sensor.measured[: len(lengths)] = lengths
        self.estimator.estimate(time, self.out)


def consistency(robot, pose, tension, *, runs, steps, force, moment, seed=0):
    """NEES (steps, runs), NIS (steps, runs) of filters of a robot that a controller holds near a pose.

    Args:
        robot: the robot.
        pose: (7,), about which it moves.
        tension: N, mean tension of the cables.
        runs: number of runs, each with its own start, wrench and noise.
        steps: number of control steps.
        force, moment: densities of the white wrench, N sqrt(s) and N m sqrt(s).
        seed: of all random numbers.
    """
    random = np.random.default_rng(seed)
    m, free = robot.m, np.zeros(6)
    free[robot.rows] = 1.0
    spread = np.repeat([START[key] for key in START], 3) * np.tile(free, 2)
    first = random.normal(size=(runs, 12)) * spread
    turn = rotations(np.tile(pose[3:], (runs, 1))) * Rotation.from_rotvec(first[:, 3:6])
    estimates = np.concatenate([pose, np.zeros(6)])
    truth = Truth(robot, (pose[:3] + first[:, :3], turn, first[:, 6:9], first[:, 9:]))
    filters = [Filter(robot, estimates, {**START, "force_noise": force, "moment_noise": moment}) for _ in range(runs)]
    sent = np.full((runs, m), tension)
    nees, nis = np.zeros((steps, runs)), np.zeros((steps, runs))
    moving = np.flatnonzero(np.tile(free, 2))
    for k in range(steps):
        length, W, _ = truth.cables(truth.place, truth.turn, truth.velocity, truth.spin)
        measured = length if k == 0 or not truth.elastic else truth.unwound
        measured = measured + NOISE * random.normal(size=(runs, m))
        for each, command, lengths in zip(filters, sent, measured, strict=True):
            each.use(k * STEP, command, lengths)
        error = errors(truth.state(), np.array([each.out for each in filters]))[:, moving]
        P = np.array([each.estimator.covariance for each in filters])[:, moving][:, :, moving]
        nees[k] = np.einsum("ni,ni->n", error, np.linalg.solve(P, error[..., None])[..., 0])
        nis[k] = [each.estimator.nis[0] for each in filters]
        sent = commands(truth, W, pose, tension, k * STEP)
        if k == 0:
            truth.start(sent)
        wrench = random.normal(size=(runs, 6)) * np.repeat([force, moment], 3) / np.sqrt(STEP) * free
        truth.advance(sent, wrench)
    return nees, nis


def commands(truth, W, pose, tension, time):
    """Tensions (N, m), N, that move platforms along a slow oscillation, with feedback of their true states."""
    swing = np.array([0.1, 0.08, 0.06]) * np.sin(4.0 * time) * truth.free[:3]
    turn = Rotation.from_rotvec(np.array([0.1, -0.08, 0.12]) * np.sin(3.0 * time) * truth.free[3:])
    offset = (turn * rotations(pose[3:]) * truth.turn.inv()).as_rotvec()
    wanted = np.concatenate(
        [100.0 * (pose[:3] + swing - truth.place) - 20.0 * truth.velocity, 100.0 * offset - 20.0 * truth.spin], 1
    )
    R = truth.turn.as_matrix()
    both = np.kron(np.eye(2), np.ones((3, 3))) * np.tile(R, (1, 2, 2))
    wrench = np.einsum("nij,jk,nlk,nl->ni", both, truth.M, both, wanted)
    wrench[:, :3] -= truth.mass * GRAVITY
    wrench[:, 3:] -= np.cross(R @ truth.c, truth.mass * GRAVITY)
    rows = truth.free == 1.0
    W = W[:, rows]
    rest = wrench[:, rows] - tension * W.sum(axis=2)
    return np.maximum(tension + np.einsum("nij,nj->ni", np.linalg.pinv(W), rest), 1.0)
