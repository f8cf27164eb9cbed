"""The reference integrator for platforms with a guide: the same scheme in the guide's coordinates."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from cdpr.cables.lines import lines
from cdpr.mechanics.geometry import cable_wrench
from cdpr.mechanics.guide import Guide, guided_acceleration, write_pose
from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.kernels import store, vector
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr.plugins.backend import Acts
from cdpr.plugins.snapshots import SnapshotOfArrays
from cdpr_backends.scheme import STAGES, along, reach, weight


class GuidedReference(SnapshotOfArrays, Backend):
    """Classical Runge-Kutta of order four in position and hinge angle, the cables evaluated at every stage."""

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.guide = guide = Guide(robot)
        self._motion = np.zeros(8)  # position, angle, velocity, spin
        self._advance = partial(
            runge_kutta,
            guide.packed,
            lines(robot),
            robot.inertial,
            self.gravity,
            self.command,
            self.external,
            self._motion,
            self.state,
            self.physics_step,
        )

    def reset(self, state: Array) -> None:
        """Put the platform into `state` (13,), which must lie in the guide."""
        self.state[:] = state
        axis = self.guide.packed[3:]
        self._motion[:] = [*state[:3], self.guide.angle(state), *self.guide.packed[:3] * state[7:10], axis @ state[10:]]
        self._advance(0)

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        self._advance(n)

    def acts(self, n: int) -> Acts:
        """Return the integrator for n physics steps."""
        return [partial(self._advance, n)]

    @property
    def arrays(self) -> tuple[Array, ...]:
        """What a snapshot must hold."""
        return self.command, self.external, self._motion, self.state


@kernel
def runge_kutta(
    guide: Array,
    lines: Array,
    inertial: Array,
    gravity: Array,
    command: Array,
    external: Array,
    motion: Array,
    state: Array,
    h: float,
    n: int,
) -> None:
    """Advance `motion` (8,) by n steps of h, then write the platform's `state`."""
    push, twist = vector(external, 0), vector(external, 3)
    for _ in range(n):
        p0, v0 = vector(motion, 0), vector(motion, 4)
        p, v = p0, v0
        angle, spin = motion[3], motion[7]
        dp, dv, turn, gain = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0
        for stage in range(STAGES):
            write_pose(guide, p, angle, v, spin, state)
            f, m = cable_wrench(lines, p, (state[3], state[4], state[5], state[6]), command)
            f = (f[0] + push[0], f[1] + push[1], f[2] + push[2])
            m = (m[0] + twist[0], m[1] + twist[1], m[2] + twist[2])
            a, alpha = guided_acceleration(guide, inertial, gravity, angle, spin, f, m)
            share = weight(stage)
            dp = along(dp, share, v)
            dv = along(dv, share, a)
            turn += share * spin
            gain += share * alpha
            if stage < 3:
                c = reach(stage, h)
                p = along(p0, c, v)
                v = along(v0, c, a)
                angle, spin = motion[3] + c * spin, motion[7] + c * alpha
        c = h / 6.0
        store(along(p0, c, dp), motion, 0)
        store(along(v0, c, dv), motion, 4)
        motion[3] += c * turn
        motion[7] += c * gain
    write_pose(guide, vector(motion, 0), motion[3], vector(motion, 4), motion[7], state)
