"""The reference backend: classical Runge-Kutta with the cables evaluated at every stage."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from cdpr.cables import immediate
from cdpr.mechanics.body_frame import BodyFrame, body_wrench, from_platform, to_platform
from cdpr.mechanics.guide import Guide
from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.kernels import conjugate, quaternion, rotate, vector
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr.plugins.snapshots import SnapshotOfArrays


def make(robot: Robot, gravity: Array, physics_step: float, options: Any) -> Backend:
    """Return the integrator of the chosen scheme for a free or a guided platform, or for cables on winches."""
    if options is not None and options.scheme == "semi_implicit_euler":
        from cdpr_backends.reference_euler import SemiImplicitEuler

        return SemiImplicitEuler(robot, gravity, physics_step, options)
    if not immediate(robot):
        from cdpr_backends.reference_winches import WinchReference

        return WinchReference(robot, gravity, physics_step, options)
    if robot.n == 6:
        return ReferenceBackend(robot, gravity, physics_step, options)
    if Guide(robot).spherical:
        from cdpr_backends.reference_spherical import SphericalReference

        return SphericalReference(robot, gravity, physics_step, options)
    from cdpr_backends.reference_guided import GuidedReference

    return GuidedReference(robot, gravity, physics_step, options)


class ReferenceBackend(SnapshotOfArrays, Backend):
    """Integrates position, attitude, momentum and angular momentum with the classical fourth-order scheme.

    The variables are those of the centre of mass; the angular momentum is kept in world axes, where a torque-free
    body does not change it, so that it is conserved to round-off.
    """

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.frame = frame = BodyFrame(robot)
        self._body = np.zeros(13)
        self._momentum = np.zeros(3)  # angular, about the centre of mass, world axes
        inertial = np.array([frame.mass, *frame.moments])
        self._advance = partial(
            runge_kutta,
            frame.lines,
            frame.offset,
            inertial,
            self.gravity,
            self.command,
            self.external,
            self._body,
            self._momentum,
            self.state,
            self.physics_step,
        )

    def reset(self, state: Array) -> None:
        """Put the platform into `state` (13,)."""
        self.state[:] = state
        from_platform(self.frame.offset, self.state, self._body)
        angular_momentum(self.frame.moments, self._body, self._momentum)
        to_platform(self.frame.offset, self._body, self.state)

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        self._advance(n)

    @property
    def arrays(self) -> tuple[Array, ...]:
        """What a snapshot must hold."""
        return self.command, self.external, self._body, self._momentum, self.state


@kernel
def angular_momentum(moments: Array, body: Array, momentum: Array) -> None:
    """Write R diag(moments) R^T omega (3,), world axes."""
    q = quaternion(body, 3)
    w = rotate(conjugate(q), vector(body, 10))
    L = rotate(q, (moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]))
    for i in range(3):
        momentum[i] = L[i]


@kernel
def runge_kutta(
    lines: Array,
    offset: Array,
    inertial: Array,
    gravity: Array,
    command: Array,
    external: Array,
    body: Array,
    momentum: Array,
    state: Array,
    h: float,
    n: int,
) -> None:
    """Advance `body` and `momentum` by n steps of h, then write the platform's `state`.

    inertial: mass and principal moments (4,). A stage is a point y = (p, q, v, L) and its slope
    (v, omega q / 2, force / mass + g, moment), with omega = R I^-1 R^T L.
    """
    mass = inertial[0]
    for _ in range(n):
        p0, q0, v0, L0 = vector(body, 0), quaternion(body, 3), vector(body, 7), vector(momentum, 0)
        p, q, v, L = p0, q0, v0, L0
        dp, dq, dv, dL = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for stage in range(4):
            f, kL = body_wrench(lines, offset, command, external, p, q)
            w = rotate(conjugate(q), L)
            w = rotate(q, (w[0] / inertial[1], w[1] / inertial[2], w[2] / inertial[3]))
            kv = (f[0] / mass + gravity[0], f[1] / mass + gravity[1], f[2] / mass + gravity[2])
            kq = (
                -0.5 * (w[0] * q[1] + w[1] * q[2] + w[2] * q[3]),
                0.5 * (w[0] * q[0] + w[1] * q[3] - w[2] * q[2]),
                0.5 * (w[1] * q[0] + w[2] * q[1] - w[0] * q[3]),
                0.5 * (w[2] * q[0] + w[0] * q[2] - w[1] * q[1]),
            )
            weight = 1.0 if stage == 0 or stage == 3 else 2.0
            dp = (dp[0] + weight * v[0], dp[1] + weight * v[1], dp[2] + weight * v[2])
            dv = (dv[0] + weight * kv[0], dv[1] + weight * kv[1], dv[2] + weight * kv[2])
            dL = (dL[0] + weight * kL[0], dL[1] + weight * kL[1], dL[2] + weight * kL[2])
            dq = (
                dq[0] + weight * kq[0],
                dq[1] + weight * kq[1],
                dq[2] + weight * kq[2],
                dq[3] + weight * kq[3],
            )
            if stage < 3:
                c = h if stage == 2 else 0.5 * h
                p = (p0[0] + c * v[0], p0[1] + c * v[1], p0[2] + c * v[2])
                q = (q0[0] + c * kq[0], q0[1] + c * kq[1], q0[2] + c * kq[2], q0[3] + c * kq[3])
                v = (v0[0] + c * kv[0], v0[1] + c * kv[1], v0[2] + c * kv[2])
                L = (L0[0] + c * kL[0], L0[1] + c * kL[1], L0[2] + c * kL[2])
        c = h / 6.0
        q = (q0[0] + c * dq[0], q0[1] + c * dq[1], q0[2] + c * dq[2], q0[3] + c * dq[3])
        norm = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
        for i in range(3):
            body[i] = p0[i] + c * dp[i]
            body[7 + i] = v0[i] + c * dv[i]
            momentum[i] = L0[i] + c * dL[i]
        for i in range(4):
            body[3 + i] = q[i] / norm
    q = quaternion(body, 3)
    w = rotate(conjugate(q), vector(momentum, 0))
    w = rotate(q, (w[0] / inertial[1], w[1] / inertial[2], w[2] / inertial[3]))
    for i in range(3):
        body[10 + i] = w[i]
    to_platform(offset, body, state)
