"""The platform on its cables, for the kernels: tensions, and what the drums add to its inertia.

`Fixed` holds what stays during a run, `Live` what changes. They are tuples of arrays, which kernels take as one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cdpr.cables.winch import INERTIA, LOWEST, RADIUS, drum_acceleration, elastic_tension, friction, pack, start_elastic
from cdpr.mechanics.body_frame import BodyFrame, applied_wrench
from cdpr.mechanics.geometry import cable_geometry, wrench_matrix_rate
from cdpr.model import Robot
from cdpr.model.cholesky import factorise, solve
from cdpr.model.jit import kernel
from cdpr.model.kernels import inverse_dynamics, quaternion, vector
from cdpr.model.robot import Array


class Fixed(NamedTuple):
    """What stays: body frame, winches and gravity."""

    elastic: bool  # else rigid
    cables: Array  # (m, 8), as `winch.pack` says
    lines: Array  # as `cdpr.cables.lines` says, B_i in the body frame, m
    offset: Array  # (7,), as `BodyFrame` says
    inertial: Array  # (13,), mass, centre of mass (3) and inertia (3, 3), body frame; laid out as `Robot.inertial`
    free: Array  # (6,), 1 for each row of a twist in which the platform moves, 0 where a guide holds it
    gravity: Array  # (3,), m/s^2


class Live(NamedTuple):
    """What changes."""

    command: Array  # (m,), N
    external: Array  # (6,), wrench at the platform's origin
    body: Array  # (13,), state of the body frame
    winch: Array  # (2 m,), unstretched lengths, m, and drum speeds, rad/s; NaN before the start; not used if rigid
    tension: Array  # (m,), N
    highest: Array  # (m,), largest size of each tension since the start, N
    applied: Array  # (6,), wrench of cables and `external` about the body frame's origin, world axes
    length: Array  # (m,), m
    rate: Array  # (m,), m/s
    W: Array  # (6, m), about the body frame's origin
    work: Array  # (1,), of the cables on the platform since the start, J
    W_rate: Array  # (6, m), and from here work space
    light: Array  # (m,), tensions without the drums' inertia, N
    pulls: Array  # (m,), 1 for each cable that pulls, 0 for one that hangs slack
    system: Array  # (6, 6)
    vectors: Array  # (5, 6)


def fixed(robot: Robot, frame: BodyFrame, gravity: Array) -> Fixed:
    """Pack what stays."""
    if frame.guide is None:
        inertial = np.concatenate([[frame.mass, 0.0, 0.0, 0.0], np.diag(frame.moments).ravel()])
    else:
        inertial = robot.inertial.copy()
    free = np.zeros(6)
    free[robot.rows] = 1.0
    elastic = robot.cable_model == "elastic"
    return Fixed(elastic, pack(robot), frame.lines, frame.offset, inertial, free, np.array(gravity))


def live(m: int, command: Array, external: Array, body: Array, applied: Array) -> Live:
    """Make what changes, around the arrays of a backend."""
    return Live(
        command=command,
        external=external,
        body=body,
        winch=np.full(2 * m, np.nan),
        tension=np.zeros(m),
        highest=np.zeros(m),
        applied=applied,
        length=np.zeros(m),
        rate=np.zeros(m),
        W=np.zeros((6, m)),
        work=np.zeros(1),
        W_rate=np.zeros((6, m)),
        light=np.zeros(m),
        pulls=np.zeros(m),
        system=np.zeros((6, 6)),
        vectors=np.zeros((5, 6)),
    )


@kernel
def settle(fixed: Fixed, live: Live) -> None:
    """Write geometry, tensions and applied wrench at `body`; add what the last tensions did on the way there."""
    m = fixed.cables.shape[0]
    before = live.light
    for i in range(m):
        before[i] = live.length[i]
    cable_geometry(fixed.lines, live.body, live.W, live.length, live.rate)
    for i in range(m):
        live.work[0] += live.tension[i] * (before[i] - live.length[i])
    pull(fixed, live)


@kernel
def step(fixed: Fixed, live: Live, h: float) -> None:
    """Settle, then advance the winches by h as semi-implicit engines do: drum speeds, with them unstretched lengths."""
    settle(fixed, live)
    if fixed.elastic:
        m = fixed.cables.shape[0]
        winch = live.winch
        for i in range(m):
            winch[m + i] += h * drum_acceleration(fixed.cables, i, live.command[i], live.tension[i], winch[m + i])
            winch[i] -= h * fixed.cables[i, RADIUS] * winch[m + i]


@kernel
def pull(fixed: Fixed, live: Live) -> None:
    """Write the tensions, and the wrench that they and the external one apply, where `length`, `rate` and W are of."""
    m = fixed.cables.shape[0]
    if fixed.elastic:
        if live.winch[0] != live.winch[0]:
            start_elastic(fixed.cables, live.command, live.length, live.rate, live.winch)
        for i in range(m):
            live.tension[i] = elastic_tension(
                fixed.cables, i, live.length[i], live.rate[i], live.winch[i], live.winch[m + i]
            )
    else:
        rigid_tensions(fixed, live)
    applied_wrench(fixed.lines, fixed.offset, live.tension, live.external, live.body, live.applied)
    for i in range(m):
        size = abs(live.tension[i])
        if size > live.highest[i]:
            live.highest[i] = size


@kernel
def rigid_tensions(fixed: Fixed, live: Live) -> None:
    """Write the tensions of rigid cables.

    T = max(0, t - m w . twist') with t the tension without the drums' inertia, m = I / r^2 and w the cable's column of
    W. Which cables pull is found by turns: with those of the last turn the platform's acceleration is solved for, and
    that says which do. One turn is enough where all pull.
    """
    cables, W, tension, light, pulls = fixed.cables, live.W, live.tension, live.light, live.pulls
    m = cables.shape[0]
    wrench_matrix_rate(fixed.lines, live.body, live.W_rate)
    for i in range(m):
        swing = 0.0  # l'' of a platform that does not accelerate
        for j in range(6):
            swing -= live.W_rate[j, i] * live.body[7 + j]
        radius = cables[i, RADIUS]
        lost = friction(cables, i, -live.rate[i] / radius) / radius
        light[i] = live.command[i] - lost + cables[i, INERTIA] / (radius * radius) * swing
        pulls[i] = 1.0
    acceleration = live.vectors[0]
    for _ in range(2 * m + 2):
        for i in range(m):
            tension[i] = pulls[i] * light[i]
        applied_wrench(fixed.lines, fixed.offset, tension, live.external, live.body, live.applied)
        mass_matrix(fixed, live)
        for i in range(m):
            reflected = pulls[i] * cables[i, INERTIA] / (cables[i, RADIUS] * cables[i, RADIUS])
            for j in range(6):
                for k in range(j + 1):
                    live.system[j, k] += reflected * W[j, i] * W[k, i] * fixed.free[j] * fixed.free[k]
        accelerate(fixed, live)
        changed = False
        for i in range(m):
            along = 0.0
            for j in range(6):
                along += W[j, i] * acceleration[j]
            tension[i] = light[i] - cables[i, INERTIA] / (cables[i, RADIUS] * cables[i, RADIUS]) * along
            slack = tension[i] < cables[i, LOWEST]
            changed = changed or slack == (pulls[i] == 1.0)
            pulls[i] = 0.0 if slack else 1.0
            if slack:
                tension[i] = 0.0
        if not changed:
            break


@kernel
def mass_matrix(fixed: Fixed, live: Live) -> None:
    """Write the lower half of the platform's mass matrix about the body frame's origin, world axes, into `system`.

    Directions in which a guide holds it are left out: there it is that of the identity.
    """
    q, still = quaternion(live.body, 3), (0.0, 0.0, 0.0)
    column, unit, weightless = live.vectors[2], live.vectors[3], live.vectors[4]
    for k in range(6):
        for j in range(6):
            unit[j] = 1.0 if j == k else 0.0
        # The inverse dynamics of a unit acceleration.
        inverse_dynamics(fixed.inertial, weightless, q, still, vector(unit, 0), vector(unit, 3), column)
        for j in range(k, 6):
            live.system[j, k] = column[j] * fixed.free[j] * fixed.free[k]
        if fixed.free[k] == 0.0:
            live.system[k, k] = 1.0


@kernel
def accelerate(fixed: Fixed, live: Live) -> None:
    """Solve for the platform's acceleration (6,) under `applied` and gravity, with `system` as mass matrix.

    It stands in `vectors[0]`, linear of the body frame's origin and angular, world axes; `system` is overwritten.
    """
    still = (0.0, 0.0, 0.0)
    acceleration, rest = live.vectors[0], live.vectors[1]
    inverse_dynamics(fixed.inertial, fixed.gravity, quaternion(live.body, 3), vector(live.body, 10), still, still, rest)
    for j in range(6):
        rest[j] = (live.applied[j] - rest[j]) * fixed.free[j]
    if factorise(live.system, 0.0):
        solve(live.system, rest, acceleration)
    else:
        for j in range(6):
            acceleration[j] = math.nan
