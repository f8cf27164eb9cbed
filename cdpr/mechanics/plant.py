"""The platform on its cables, for the kernels: tensions, and what the drums add to its inertia.

`Fixed` holds what stays during a run, `Live` what changes. They are tuples of arrays, which kernels take as one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cdpr.cables import chain_of
from cdpr.cables.pack import BENT, BENT_PULL, DRIVE, HELD, LOWEST, PULL, REST, SPAN, STRAIGHT, TURN, WINCH, pack
from cdpr.mechanics.body_frame import BodyFrame, applied_wrench
from cdpr.mechanics.geometry import cable_geometry, chord, exit_point_and_length, tip, wrench_matrix_rate
from cdpr.model import Robot
from cdpr.model.address import caller
from cdpr.model.cholesky import factorise, solve
from cdpr.model.jit import apart, kernel
from cdpr.model.kernels import Vector, conjugate, cross, inverse_dynamics, logarithm, multiply, quaternion, vector
from cdpr.model.robot import Array

held, turn = (caller(DRIVE[name]) for name in ("held", "turn"))
pulled, rest = (caller(STRAIGHT[name]) for name in ("pull", "rest"))
bent_pull, bent_rest = (caller(BENT[name]) for name in ("pull", "rest"))


class Fixed(NamedTuple):
    """What stays: body frame, winches, spans and gravity."""

    stretches: bool  # whether some cable does
    bends: bool  # whether some cable does, so that its force is not along its chord
    cables: Array  # as `cdpr.cables.pack` says
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
    winch: Array  # (2 m,), unwound lengths, m, and drum speeds, rad/s; NaN before the start; 0 of what does not stretch
    tension: Array  # (m,), N
    highest: Array  # (m,), largest size of each tension since the start, N
    applied: Array  # (6,), wrench of cables and `external` about the body frame's origin, world axes
    length: Array  # (m,), m
    rate: Array  # (m,), m/s
    W: Array  # (6, m), about the body frame's origin
    work: Array  # (1,), of the cables on the platform since the start, J
    beside: Array  # (6,), what bent cables exert besides their tensions along their chords, laid out as `applied`
    place: Array  # (7,), pose of the body frame when `work` was last added to, of plants with bent cables
    W_rate: Array  # (6, m), and from here work space
    light: Array  # (m,), tensions without the drums' inertia, N
    mass: Array  # (m,), what that inertia is along the cable, kg
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
    chains = [chain_of(robot, cable) for cable in robot.cables]
    stretches, bends = any(chain.stretches for chain in chains), any(chain.span.bends for chain in chains)
    return Fixed(stretches, bends, pack(robot).copy(), frame.lines, frame.offset, inertial, free, np.array(gravity))


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
        beside=np.zeros(6),
        place=np.zeros(7),
        W_rate=np.zeros((6, m)),
        light=np.zeros(m),
        mass=np.zeros(m),
        pulls=np.zeros(m),
        system=np.zeros((6, 6)),
        vectors=np.zeros((5, 6)),
    )


@apart
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
    if fixed.bends:
        live.work[0] += moved(live)
    pull(fixed, live)


@apart
@kernel
def moved(live: Live) -> float:
    """Return the work, J, of `beside` on the way from `place` to `body`, and make that the place."""
    turned = logarithm(multiply(quaternion(live.body, 3), conjugate(quaternion(live.place, 3))))
    work = 0.0
    for i in range(3):
        work += live.beside[i] * (live.body[i] - live.place[i]) + live.beside[3 + i] * turned[i]
    for i in range(7):
        live.place[i] = live.body[i]
    return work


@kernel
def step(fixed: Fixed, live: Live, h: float) -> None:
    """Settle, then advance the winches by h as semi-implicit engines do: speeds, with them unwound lengths."""
    settle(fixed, live)
    if fixed.stretches:
        m = fixed.cables.shape[0]
        winch = live.winch
        for i in range(m):
            if fixed.cables[i, REST] != 0.0:
                winch[m + i] += h * speeding(fixed, live, i)
                winch[i] -= h * fixed.cables[i, WINCH] * winch[m + i]


@kernel
def speeding(fixed: Fixed, live: Live, i: int) -> float:
    """Return by how much a second the speed of winch i grows under the tension of its cable."""
    row = fixed.cables[i]
    speed = live.winch[fixed.cables.shape[0] + i]
    growth: float = turn(row[TURN], row[WINCH:SPAN], live.command[i], live.tension[i], speed)
    return growth


@kernel
def start(fixed: Fixed, live: Live) -> None:
    """Write unwound lengths and speeds at which each tension is its command and no cable stretches further."""
    m = fixed.cables.shape[0]
    for i in range(m):
        row = fixed.cables[i]
        live.winch[i], live.winch[m + i] = 0.0, 0.0
        if row[REST] != 0.0:
            if row[PULL] != 0.0:
                live.winch[i] = rest(row[REST], row[SPAN:], live.length[i], live.command[i])
            else:
                live.winch[i] = unwind(fixed, live, i)
            live.winch[m + i] = -live.rate[i] / row[WINCH]


@kernel
def pull(fixed: Fixed, live: Live) -> None:
    """Write the tensions, and the wrench that they and the external one apply, where `length`, `rate` and W are of."""
    m = fixed.cables.shape[0]
    if fixed.stretches and live.winch[0] != live.winch[0]:
        start(fixed, live)
    if tell(fixed, live):
        share(fixed, live)
    apply(fixed, live)
    for i in range(m):
        size = abs(live.tension[i])
        if size > live.highest[i]:
            live.highest[i] = size


@kernel
def apply(fixed: Fixed, live: Live) -> None:
    """Write into `applied` what tensions, bent cables and the external wrench do."""
    applied_wrench(fixed.lines, fixed.offset, live.tension, live.external, live.body, live.applied)
    if fixed.bends:
        for j in range(6):
            live.applied[j] += live.beside[j]


@kernel
def run(fixed: Fixed, live: Live, i: int) -> tuple[Vector, Vector, float]:
    """Return the lever of cable i's anchor on the body, its chord from there (3,), and its length on the exit, m."""
    p = vector(live.body, 0)
    b, P = tip(fixed.lines, i, p, quaternion(live.body, 3))
    E = exit_point_and_length(fixed.lines, i, P)
    away, _ = chord(p, b, (E[0], E[1], E[2]))
    return b, away, E[3]


@apart
@kernel
def unwind(fixed: Fixed, live: Live, i: int) -> float:
    """Return the unwound length at which the tension of a bent cable is its command."""
    row = fixed.cables[i]
    _, away, wound = run(fixed, live, i)
    unwound: float = bent_rest(row[REST], row[SPAN:], away, wound, live.command[i], vector(fixed.gravity, 0))
    return unwound


@apart
@kernel
def bend(fixed: Fixed, live: Live) -> None:
    """Write the tensions of bent cables at their winches, and into `beside` what their forces differ from these by."""
    m = fixed.cables.shape[0]
    gravity = vector(fixed.gravity, 0)
    for j in range(6):
        live.beside[j] = 0.0
    for i in range(m):
        row = fixed.cables[i]
        if row[BENT_PULL] == 0.0:
            continue
        b, away, wound = run(fixed, live, i)
        stretching = live.rate[i] + row[WINCH] * live.winch[m + i]
        end = bent_pull(row[BENT_PULL], row[SPAN:], away, wound, live.winch[i], stretching, row[LOWEST], gravity)
        live.light[i] = end[3]
        live.tension[i] = end[3]
        f = (end[0] - end[3] * live.W[0, i], end[1] - end[3] * live.W[1, i], end[2] - end[3] * live.W[2, i])
        c = cross(b, f)
        for j in range(3):
            live.beside[j] += f[j]
            live.beside[3 + j] += c[j]


@kernel
def tell(fixed: Fixed, live: Live) -> bool:
    """Write tensions free of the drums' inertia, and what that is along the cables; tell whether any has some."""
    m = fixed.cables.shape[0]
    swinging, heavy = False, False
    for i in range(m):
        row = fixed.cables[i]
        live.mass[i] = 0.0
        if row[PULL] != 0.0:
            unwound, stretching = live.winch[i], live.rate[i] + row[WINCH] * live.winch[m + i]
            live.light[i] = pulled(row[PULL], row[SPAN:], live.length[i], unwound, stretching, row[LOWEST])
        elif row[REST] == 0.0:
            if not swinging:
                wrench_matrix_rate(fixed.lines, live.body, live.W_rate)
                swinging = True
            swing = 0.0  # l'' of a platform that does not accelerate
            for j in range(6):
                swing -= live.W_rate[j, i] * live.body[7 + j]
            live.light[i], live.mass[i] = held(row[HELD], row[WINCH:SPAN], live.command[i], live.rate[i], swing)
            heavy = heavy or live.mass[i] != 0.0
        live.tension[i] = live.light[i]
    if fixed.bends:
        bend(fixed, live)
    return heavy


@apart
@kernel
def share(fixed: Fixed, live: Live) -> None:
    """Take from the tensions what the drums' inertia needs to go with the platform.

    T = max(0, t - m w . twist') with t the tension without it, m the mass that it is along the cable and w the cable's
    column of W. Which cables pull is found by turns: with those of the last turn the platform's acceleration is solved
    for, and that says which do. One turn is enough where all pull.
    """
    W, tension, light, mass, pulls = live.W, live.tension, live.light, live.mass, live.pulls
    m = tension.shape[0]
    for i in range(m):
        pulls[i] = 1.0
    acceleration = live.vectors[0]
    for _ in range(2 * m + 2):
        for i in range(m):
            tension[i] = pulls[i] * light[i]
        apply(fixed, live)
        mass_matrix(fixed, live)
        for i in range(m):
            reflected = pulls[i] * mass[i]
            for j in range(6):
                for k in range(j + 1):
                    live.system[j, k] += reflected * W[j, i] * W[k, i] * fixed.free[j] * fixed.free[k]
        accelerate(fixed, live)
        changed = False
        for i in range(m):
            if mass[i] == 0.0:
                tension[i] = light[i]
                continue
            along = 0.0
            for j in range(6):
                along += W[j, i] * acceleration[j]
            tension[i] = light[i] - mass[i] * along
            slack = tension[i] < fixed.cables[i, LOWEST]
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
