"""Lengths, directions and rates of the cables, and what they exert: compiled. Conventions: see `cdpr.model`.

`lines` is what `cdpr.cables.lines` returns: (m, 6) anchors, or more columns where cables leave from something else than
a point.
"""

from __future__ import annotations

import math

from cdpr.cables.lines import ANCHORS, CARRY, LEAD, LEAVE, SIGNATURES
from cdpr.model.address import caller
from cdpr.model.jit import apart, kernel
from cdpr.model.kernels import Quaternion, Vector, cross, dot, quaternion, rotate, vector
from cdpr.model.lanes import of_lanes
from cdpr.model.robot import Array

leave, lead, carry = (caller(SIGNATURES[name]) for name in ("leave", "lead", "carry"))


def exit_point(lines: Array, i: int, P: Vector) -> Vector:
    """Return where cable i leaves the frame (3,) on its way to P (3,), m, world axes."""
    if lines.shape[1] > ANCHORS and lines[i, LEAVE] != 0.0:
        point: Vector = leave(lines[i, LEAVE], lines[i], P)
        return point
    return (lines[i, 0], lines[i, 1], lines[i, 2])


@of_lanes(exit_point)
def _point(lines: Array, i: int, P: Vector) -> Vector:
    """Return where cable i of each lane leaves the frame: from a point, for lanes know no others."""
    return (lines[i, 0], lines[i, 1], lines[i, 2])


def exit_point_and_length(lines: Array, i: int, P: Vector) -> tuple[float, float, float, float]:
    """Return that point, and the length of cable, m, that lies on the exit."""
    if lines.shape[1] > ANCHORS and lines[i, LEAD] != 0.0:
        led: tuple[float, float, float, float] = lead(lines[i, LEAD], lines[i], P)
        return led
    return (lines[i, 0], lines[i, 1], lines[i, 2], 0.0)


@of_lanes(exit_point_and_length)
def _point_and_length(lines: Array, i: int, P: Vector) -> tuple[float, float, float, float]:
    """Return that point; there is no cable on it."""
    return (lines[i, 0], lines[i, 1], lines[i, 2], 0.0)


@kernel
def exit_velocity(lines: Array, i: int, P: Vector, V: Vector) -> Vector:
    """Return the velocity of the exit point, m/s, when P moves with V."""
    if lines.shape[1] > ANCHORS and lines[i, CARRY] != 0.0:
        velocity: Vector = carry(lines[i, CARRY], lines[i], P, V)
        return velocity
    return (0.0, 0.0, 0.0)


@kernel
def tip(lines: Array, i: int, p: Vector, q: Quaternion) -> tuple[Vector, Vector]:
    """Return the lever of cable i's anchor on a body at p with attitude q, and where that anchor is, m, world axes."""
    b = rotate(q, (lines[i, 3], lines[i, 4], lines[i, 5]))
    return b, (p[0] + b[0], p[1] + b[1], p[2] + b[2])


@kernel
def chord(p: Vector, b: Vector, E: Vector) -> tuple[Vector, float]:
    """Return the vector from the anchor with lever b on a body at p to the exit point E, and its length, m."""
    l = (E[0] - p[0] - b[0], E[1] - p[1] - b[1], E[2] - p[2] - b[2])  # noqa: E741
    return l, math.sqrt(dot(l, l))


@kernel
def column(p: Vector, b: Vector, E: Vector) -> tuple[Vector, Vector, float]:
    """Return the direction of that chord, its moment about the body's origin, and its length, m."""
    l, norm = chord(p, b, E)  # noqa: E741
    u = (l[0] / norm, l[1] / norm, l[2] / norm)
    return u, cross(b, u), norm


@kernel
def write_column(u: Vector, c: Vector, W: Array, i: int) -> None:
    """Write a direction and its moment into column i of a wrench matrix (6, m)."""
    for j in range(3):
        W[j, i] = u[j]
        W[3 + j, i] = c[j]


@kernel
def point_columns(lines: Array, state: Array, W: Array) -> None:
    """Write the wrench matrix (6, m) at `state` where all cables leave from points; of lanes, too."""
    p, q = vector(state, 0), quaternion(state, 3)
    for i in range(lines.shape[0]):
        b, _ = tip(lines, i, p, q)
        u, c, _ = column(p, b, (lines[i, 0], lines[i, 1], lines[i, 2]))
        write_column(u, c, W, i)


@apart
@kernel
def cable_geometry(lines: Array, state: Array, W: Array, length: Array, rate: Array) -> None:
    """Write the wrench matrix (6, m), the lengths (m,) and their rates (m,) at `state`; see above for `lines`.

    With the platform's twist, rate = -W^T twist: a cable shortens where it pulls along the motion.
    """
    p = vector(state, 0)
    q = quaternion(state, 3)
    v = vector(state, 7)
    omega = vector(state, 10)
    for i in range(lines.shape[0]):
        b, P = tip(lines, i, p, q)
        E = exit_point_and_length(lines, i, P)
        u, c, norm = column(p, b, (E[0], E[1], E[2]))
        write_column(u, c, W, i)
        length[i] = norm + E[3]
        rate[i] = -dot(u, v) - dot(c, omega)


@apart
@kernel
def wrench_matrix_rate(lines: Array, state: Array, rate: Array) -> None:
    """Write the time derivative (6, m) of the wrench matrix at `state`."""
    p = vector(state, 0)
    q = quaternion(state, 3)
    v = vector(state, 7)
    omega = vector(state, 10)
    for i in range(lines.shape[0]):
        b, P = tip(lines, i, p, q)
        db = cross(omega, b)
        l, norm = chord(p, b, exit_point(lines, i, P))  # noqa: E741
        u = (l[0] / norm, l[1] / norm, l[2] / norm)
        dE = exit_velocity(lines, i, P, (v[0] + db[0], v[1] + db[1], v[2] + db[2]))
        dl = (dE[0] - v[0] - db[0], dE[1] - v[1] - db[1], dE[2] - v[2] - db[2])
        along = dot(u, dl)
        du = ((dl[0] - along * u[0]) / norm, (dl[1] - along * u[1]) / norm, (dl[2] - along * u[2]) / norm)
        c1 = cross(db, u)
        c2 = cross(b, du)
        rate[0, i] = du[0]
        rate[1, i] = du[1]
        rate[2, i] = du[2]
        rate[3, i] = c1[0] + c2[0]
        rate[4, i] = c1[1] + c2[1]
        rate[5, i] = c1[2] + c2[2]


@kernel
def cable_wrench(lines: Array, p: Vector, q: Quaternion, tension: Array) -> tuple[Vector, Vector]:
    """Force and moment about p, world axes, of the tensions (m,) on a body at p with attitude q."""
    fx, fy, fz, mx, my, mz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(lines.shape[0]):
        b, P = tip(lines, i, p, q)
        l, norm = chord(p, b, exit_point(lines, i, P))  # noqa: E741
        scale = tension[i] / norm
        f = (scale * l[0], scale * l[1], scale * l[2])
        c = cross(b, f)
        fx += f[0]
        fy += f[1]
        fz += f[2]
        mx += c[0]
        my += c[1]
        mz += c[2]
    return (fx, fy, fz), (mx, my, mz)


@kernel
def leaving(lines: Array, tips: Array, points: Array) -> None:
    """Write where the cables leave the frame, (K, m, 3), m, world, for platform anchors at `tips` (K, m, 3)."""
    for k in range(tips.shape[0]):
        for i in range(lines.shape[0]):
            E = exit_point(lines, i, vector(tips[k, i], 0))
            for j in range(3):
                points[k, i, j] = E[j]
