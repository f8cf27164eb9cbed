"""The equations of `cdpr.cables.pulley`."""

from __future__ import annotations

import math

from cdpr.cables.lines import NUMBERS
from cdpr.model.jit import kernel
from cdpr.model.kernels import Vector, dot, vector
from cdpr.model.robot import Array

RADIUS, AXIS, SIDE = NUMBERS, NUMBERS + 1, NUMBERS + 4

# The wrap angle is counted from minus a quarter turn: round-off about 0 is no full turn, and no cable wraps three.
FIRST = -0.5 * math.pi


@kernel
def leave(row: Array, P: Vector) -> Vector:
    """Return the exit point."""
    radius, axis = row[RADIUS], vector(row, AXIS)
    out, c, z, f = _plane(row, P)
    square = c * c + z * z
    up, away = radius * ((f * c + radius * z) / square), radius * (1.0 - (f * z - radius * c) / square)
    return (
        row[0] + away * out[0] + up * axis[0],
        row[1] + away * out[1] + up * axis[1],
        row[2] + away * out[2] + up * axis[2],
    )


@kernel
def wound(row: Array, P: Vector) -> float:
    """Return the arc on which the cable lies."""
    radius: float = row[RADIUS]
    _, c, z, f = _plane(row, P)
    angle = math.atan2(f * c + radius * z, f * z - radius * c)
    return radius * (angle if angle >= FIRST else angle + 2.0 * math.pi)


@kernel
def carry(row: Array, P: Vector, V: Vector) -> Vector:
    """Return the exit point's velocity: the tangent turns with V across it, the plane with V out of it."""
    radius, axis = row[RADIUS], vector(row, AXIS)
    out, c, z, f = _plane(row, P)
    square = c * c + z * z
    sine, cosine = (f * c + radius * z) / square, (f * z - radius * c) / square
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
    out = (away[0] / x, away[1] / x, away[2] / x) if x > 0.0 else vector(row, SIDE)
    return out, x - radius, z, math.sqrt(x * (x - 2.0 * radius) + z * z)
