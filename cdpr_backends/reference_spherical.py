"""The reference integrator for platforms that turn about their held origin, by the scheme of the free platform."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from cdpr.cables.lines import lines
from cdpr.mechanics.geometry import cable_wrench
from cdpr.mechanics.spherical import INERTIA, INVERSE, moment_about_ball, pack, turned_product
from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.kernels import quaternion, store, vector
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr.plugins.snapshots import SnapshotOfArrays


class SphericalReference(SnapshotOfArrays, Backend):
    """Classical Runge-Kutta of order four in attitude and angular momentum about the origin.

    The momentum is kept in world axes, so that a torque-free body conserves it to round-off.
    """

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self._packed = pack(robot)
        self._momentum = np.zeros(3)
        self._advance = partial(
            runge_kutta,
            lines(robot),
            self._packed,
            self.gravity,
            self.command,
            self.external,
            self._momentum,
            self.state,
            self.physics_step,
        )

    def reset(self, state: Array) -> None:
        """Put the platform into `state` (13,), whose velocity must be zero."""
        self.state[:] = state
        self.state[7:10] = 0.0
        start = turned_product(self._packed, INERTIA, quaternion(self.state, 3), vector(self.state, 10))
        self._momentum[:] = start

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        self._advance(n)

    @property
    def arrays(self) -> tuple[Array, ...]:
        """What a snapshot must hold."""
        return self.command, self.external, self._momentum, self.state


@kernel
def runge_kutta(
    lines: Array,
    packed: Array,
    gravity: Array,
    command: Array,
    external: Array,
    momentum: Array,
    state: Array,
    h: float,
    n: int,
) -> None:
    """Advance attitude and angular velocity in `state` (13,), and `momentum`, by n steps of h.

    A stage is a point (q, L) and its slope (omega q / 2, moment), with omega = R J^-1 R^T L.
    """
    p = vector(state, 0)
    for _ in range(n):
        q0, L0 = quaternion(state, 3), vector(momentum, 0)
        q, L = q0, L0
        dq, dL = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for stage in range(4):
            _, m = cable_wrench(lines, p, q, command)
            m = (m[0] + external[3], m[1] + external[4], m[2] + external[5])
            kL = moment_about_ball(packed, gravity, q, m)
            w = turned_product(packed, INVERSE, q, L)
            kq = (
                -0.5 * (w[0] * q[1] + w[1] * q[2] + w[2] * q[3]),
                0.5 * (w[0] * q[0] + w[1] * q[3] - w[2] * q[2]),
                0.5 * (w[1] * q[0] + w[2] * q[1] - w[0] * q[3]),
                0.5 * (w[2] * q[0] + w[0] * q[2] - w[1] * q[1]),
            )
            weight = 1.0 if stage == 0 or stage == 3 else 2.0
            dL = (dL[0] + weight * kL[0], dL[1] + weight * kL[1], dL[2] + weight * kL[2])
            dq = (
                dq[0] + weight * kq[0],
                dq[1] + weight * kq[1],
                dq[2] + weight * kq[2],
                dq[3] + weight * kq[3],
            )
            if stage < 3:
                c = h if stage == 2 else 0.5 * h
                q = (q0[0] + c * kq[0], q0[1] + c * kq[1], q0[2] + c * kq[2], q0[3] + c * kq[3])
                L = (L0[0] + c * kL[0], L0[1] + c * kL[1], L0[2] + c * kL[2])
        c = h / 6.0
        q = (q0[0] + c * dq[0], q0[1] + c * dq[1], q0[2] + c * dq[2], q0[3] + c * dq[3])
        norm = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
        for i in range(3):
            momentum[i] = L0[i] + c * dL[i]
        for i in range(4):
            state[3 + i] = q[i] / norm
    store(turned_product(packed, INVERSE, quaternion(state, 3), vector(momentum, 0)), state, 10)
