"""The reference backend: classical Runge-Kutta with the cables evaluated at every stage."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from cdpr.cables import immediate
from cdpr.mechanics.body_frame import BodyFrame, body_wrench, from_platform, to_platform
from cdpr.mechanics.guide import Guide
from cdpr.model import Robot
from cdpr.model.jit import any_width, kernel
from cdpr.model.kernels import conjugate, quaternion, rotate, store, vector
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr.plugins.backend import Acts
from cdpr.plugins.snapshots import SnapshotOfArrays
from cdpr_backends.scheme import STAGES, along, along4, normalised, reach, turning, weight


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
        begin(self.frame.offset, self.frame.moments, self.state, self._body, self._momentum)

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        self._advance(n)

    def acts(self, n: int) -> Acts:
        """Return the integrator for n physics steps."""
        return [partial(self._advance, n)]

    @property
    def arrays(self) -> tuple[Array, ...]:
        """What a snapshot must hold."""
        return self.command, self.external, self._body, self._momentum, self.state


@kernel
def begin(offset: Array, moments: Array, state: Array, body: Array, momentum: Array) -> None:
    """Write body state and angular momentum R diag(moments) R^T omega (3,), world axes, of the platform's state."""
    from_platform(offset, state, body)
    q = quaternion(body, 3)
    w = rotate(conjugate(q), vector(body, 10))
    store(rotate(q, (moments[0] * w[0], moments[1] * w[1], moments[2] * w[2])), momentum, 0)
    to_platform(offset, body, state)


@any_width
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
        for stage in range(STAGES):
            f, kL = body_wrench(lines, offset, command, external, p, q)
            w = rotate(conjugate(q), L)
            w = rotate(q, (w[0] / inertial[1], w[1] / inertial[2], w[2] / inertial[3]))
            kv = (f[0] / mass + gravity[0], f[1] / mass + gravity[1], f[2] / mass + gravity[2])
            kq = turning(q, w)
            share = weight(stage)
            dp = along(dp, share, v)
            dv = along(dv, share, kv)
            dL = along(dL, share, kL)
            dq = along4(dq, share, kq)
            if stage < 3:
                c = reach(stage, h)
                p = along(p0, c, v)
                q = along4(q0, c, kq)
                v = along(v0, c, kv)
                L = along(L0, c, kL)
        c = h / 6.0
        q = normalised(along4(q0, c, dq))
        store(along(p0, c, dp), body, 0)
        store(along(v0, c, dv), body, 7)
        store(along(L0, c, dL), momentum, 0)
        for i in range(4):
            body[3 + i] = q[i]
    q = quaternion(body, 3)
    w = rotate(conjugate(q), vector(momentum, 0))
    w = rotate(q, (w[0] / inertial[1], w[1] / inertial[2], w[2] / inertial[3]))
    for i in range(3):
        body[10 + i] = w[i]
    to_platform(offset, body, state)
