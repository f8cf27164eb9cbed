"""The reference integrator for platforms that turn about their held origin, by the scheme of the free platform."""

from __future__ import annotations

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
from cdpr.plugins.backend import Acts
from cdpr.plugins.snapshots import SnapshotOfArrays
from cdpr_backends.scheme import STAGES, along, along4, normalised, reach, turning, weight


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

    def acts(self, n: int) -> Acts:
        """Return the integrator for n physics steps."""
        return [partial(self._advance, n)]

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
        for stage in range(STAGES):
            _, m = cable_wrench(lines, p, q, command)
            m = (m[0] + external[3], m[1] + external[4], m[2] + external[5])
            kL = moment_about_ball(packed, gravity, q, m)
            w = turned_product(packed, INVERSE, q, L)
            kq = turning(q, w)
            share = weight(stage)
            dL = along(dL, share, kL)
            dq = along4(dq, share, kq)
            if stage < 3:
                c = reach(stage, h)
                q = along4(q0, c, kq)
                L = along(L0, c, kL)
        c = h / 6.0
        q = normalised(along4(q0, c, dq))
        store(along(L0, c, dL), momentum, 0)
        for i in range(4):
            state[3 + i] = q[i]
    store(turned_product(packed, INVERSE, quaternion(state, 3), vector(momentum, 0)), state, 10)
