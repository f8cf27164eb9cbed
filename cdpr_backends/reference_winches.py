"""The reference integrator for cables on winches: their states are integrated with the platform's, stage by stage."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from cdpr.cables.pack import REST, WINCH
from cdpr.mechanics.body_frame import BodyFrame, from_platform, to_platform
from cdpr.mechanics.geometry import cable_geometry
from cdpr.mechanics.plant import Fixed, Live, accelerate, mass_matrix, pull, settle, speeding
from cdpr.mechanics.winches import Winches
from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.kernels import copy, quaternion, vector
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr.plugins.backend import Acts
from cdpr.plugins.snapshots import SnapshotOfArrays
from cdpr_backends.scheme import STAGES, normalised, reach, turning, weight


class WinchReference(SnapshotOfArrays, Backend):
    """Classical Runge-Kutta of order four in body, winches and work of the cables, for free and guided platforms."""

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.frame = frame = BodyFrame(robot)
        self._body, applied = np.zeros(13), np.zeros(6)
        self.winches = Winches(
            robot, frame, self.gravity, self.command, self.external, self._body, applied, physics_step
        )
        self.highest = self.winches.live.highest
        work = np.zeros((4, 14 + (2 * robot.m if self.winches.fixed.stretches else 0)))
        self._advance = partial(runge_kutta, self.winches.fixed, self.winches.live, self.state, work, self.physics_step)

    def reset(self, state: Array) -> None:
        """Put the platform into `state` (13,), which must lie in the guide, if there is one."""
        free = self.winches.fixed.free
        self.state[:] = state
        self.state[7:] *= free
        from_platform(self.frame.offset, self.state, self._body)
        to_platform(self.frame.offset, self._body, self.state)
        self.winches.reset()

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        self._advance(n)

    def acts(self, n: int) -> Acts:
        """Return the integrator for n physics steps."""
        return [partial(self._advance, n)]

    def read_tension(self, tension: Array) -> None:
        """Write the tensions (m,)."""
        self.winches.settle()
        tension[:] = self.winches.live.tension

    def readings(self, tension: Array, work: Array) -> tuple[Acts, Acts] | None:
        """Return the kernels that do so; the work is integrated with all else."""
        tensions, _ = self.winches.readings(tension, work)
        return tensions, [partial(copy, self.winches.live.work, work)]

    def cable_work(self) -> float:
        """Return the work of the cables on the platform, J."""
        return float(self.winches.live.work[0])

    @property
    def arrays(self) -> tuple[Array, ...]:
        """What a snapshot must hold."""
        return self.command, self.external, self._body, self.state, *self.winches.arrays


@kernel
def runge_kutta(fixed: Fixed, live: Live, state: Array, space: Array, h: float, n: int) -> None:
    """Advance body, winches and work by n steps of h, then write the platform's `state`.

    `space` (4, 14 + 2 m), without the winches where no cable stretches, holds the start of a step, the point of a
    stage, its slope and the sum of the slopes: body (13), work, winches (2 m).
    """
    start, point, slope, total = space[0], space[1], space[2], space[3]
    size = start.shape[0]
    for _ in range(n):
        settle(fixed, live)  # where the winches start, their states are known only then
        gather(live, start)
        for i in range(size):
            total[i] = 0.0
            point[i] = start[i]
        for stage in range(STAGES):
            scatter(point, live)
            slopes(fixed, live, slope)
            share, c = weight(stage), reach(stage, h)
            for i in range(size):
                total[i] += share * slope[i]
                point[i] = start[i] + c * slope[i]
        for i in range(size):
            point[i] = start[i] + h / 6.0 * total[i]
        q = normalised(quaternion(point, 3))
        for i in range(4):
            point[3 + i] = q[i]
        scatter(point, live)
        for i in range(live.tension.shape[0]):
            live.tension[i] = 0.0  # the work is integrated here, `settle` has nothing to add
        for i in range(6):
            live.beside[i] = 0.0
    settle(fixed, live)
    to_platform(fixed.offset, live.body, state)


@kernel
def gather(live: Live, point: Array) -> None:
    """Read body, work and winches."""
    for i in range(13):
        point[i] = live.body[i]
    point[13] = live.work[0]
    for i in range(14, point.shape[0]):
        point[i] = live.winch[i - 14]


@kernel
def scatter(point: Array, live: Live) -> None:
    """Undo `gather`."""
    for i in range(13):
        live.body[i] = point[i]
    live.work[0] = point[13]
    for i in range(14, point.shape[0]):
        live.winch[i - 14] = point[i]


@kernel
def slopes(fixed: Fixed, live: Live, slope: Array) -> None:
    """Write the time derivatives of body, work and winches."""
    cable_geometry(fixed.lines, live.body, live.W, live.length, live.rate)
    pull(fixed, live)
    mass_matrix(fixed, live)
    accelerate(fixed, live)
    dq = turning(quaternion(live.body, 3), vector(live.body, 10))
    for i in range(4):
        slope[3 + i] = dq[i]
    acceleration = live.vectors[0]
    for i in range(3):
        slope[i] = live.body[7 + i]
        slope[7 + i] = acceleration[i]
        slope[10 + i] = acceleration[3 + i]
    slope[13] = 0.0
    if fixed.bends:
        for i in range(6):
            slope[13] += live.beside[i] * live.body[7 + i]
    m = fixed.cables.shape[0]
    for i in range(m):
        slope[13] -= live.tension[i] * live.rate[i]
        if fixed.stretches:
            slope[14 + i], slope[14 + m + i] = 0.0, 0.0
            if fixed.cables[i, REST] != 0.0:
                slope[14 + i] = -fixed.cables[i, WINCH] * live.winch[m + i]
                slope[14 + m + i] = speeding(fixed, live, i)
