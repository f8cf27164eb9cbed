"""The equations of `cdpr.cables.pulley`."""

from __future__ import annotations

import math

from cdpr.cables.lines import NUMBERS
from cdpr.model.jit import kernel
from cdpr.model.kernels import Vector, dot, vector
from cdpr.model.robot import Array

RADIUS, AXIS, SIDE = NUMBERS, NUMBERS + 1, NUMBERS + 4

# The wrap angle is counted from minus a quarter turn: round-off about 0 is no full turn, and no cable wraps so far.
FIRST = -0.5 * math.pi


@kernel
def leave(row: Array, P: Vector) -> Vector:
    """Return the exit point."""
    out, c, z, f = _plane(row, P)
    sine, cosine = _angle(row[RADIUS], c, z, f)
    return _point(row, out, sine, cosine)


@kernel
def lead(row: Array, P: Vector) -> tuple[float, float, float, float]:
    """Return the exit point, and the arc on which the cable lies."""
    out, c, z, f = _plane(row, P)
    sine, cosine = _angle(row[RADIUS], c, z, f)
    angle = math.atan2(sine, cosine)
    if z < 0.0 and sine < 0.0 and cosine > 0.0:
        angle = math.nan  # more than three quarters of a turn: it would cross where it arrives
    E = _point(row, out, sine, cosine)
    return (E[0], E[1], E[2], row[RADIUS] * (angle if angle >= FIRST else angle + 2.0 * math.pi))


@kernel
def carry(row: Array, P: Vector, V: Vector) -> Vector:
    """Return the exit point's velocity: the tangent turns with V across it, the plane with V out of it."""
    radius, axis = row[RADIUS], vector(row, AXIS)
    out, c, z, f = _plane(row, P)
    sine, cosine = _angle(radius, c, z, f)
    forth, along = dot(V, out), dot(V, axis)
    turn = radius * (cosine * forth - sine * along) / f
    far = c + radius
    swing = radius * (1.0 - cosine) / far if far > 0.0 else 0.0
    return (
        turn * (sine * out[0] + cosine * axis[0]) + swing * (V[0] - forth * out[0] - along * axis[0]),
        turn * (sine * out[1] + cosine * axis[1]) + swing * (V[1] - forth * out[1] - along * axis[1]),
        turn * (sine * out[2] + cosine * axis[2]) + swing * (V[2] - forth * out[2] - along * axis[2]),
    )


@kernel
def _plane(row: Array, P: Vector) -> tuple[Vector, float, float, float]:
    """Return the plane's direction away from the axis, P in it from the centre, and the tangent's length."""
    radius, axis = row[RADIUS], vector(row, AXIS)
    d = (P[0] - row[0], P[1] - row[1], P[2] - row[2])
    z = dot(d, axis)
    away = (d[0] - z * axis[0], d[1] - z * axis[1], d[2] - z * axis[2])
    x = math.sqrt(dot(away, away))
    per = 1.0 / x
    out = (per * away[0], per * away[1], per * away[2]) if x > 0.0 else vector(row, SIDE)
    return out, x - radius, z, math.sqrt(x * (x - 2.0 * radius) + z * z)


@kernel
def _angle(radius: float, c: float, z: float, f: float) -> tuple[float, float]:
    """Return sine and cosine of the wrap angle."""
    per = 1.0 / (c * c + z * z)
    return per * (f * c + radius * z), per * (f * z - radius * c)


@kernel
def _point(row: Array, out: Vector, sine: float, cosine: float) -> Vector:
    """Return the point of the groove at a wrap angle."""
    away, up, axis = row[RADIUS] * (1.0 - cosine), row[RADIUS] * sine, vector(row, AXIS)
    return (
        row[0] + away * out[0] + up * axis[0],
        row[1] + away * out[1] + up * axis[1],
        row[2] + away * out[2] + up * axis[2],
    )
