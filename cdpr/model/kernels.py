"""The compiled mathematics of the loop. Conventions: see `cdpr.model`.

Vectors that stay inside a kernel are tuples, which the compiler keeps in registers; arrays come in and go out.
`NUMBA_DISABLE_JIT=1` runs the same source as plain Python.
"""

from __future__ import annotations

import math

from cdpr.model.jit import any_width, apart, kernel
from cdpr.model.lanes import choose
from cdpr.model.robot import Array

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

# Below this half-angle sine the rotation vector is 2 q_xyz to within 1e-16 relative (the next term is sine^2 / 6).
SMALL_SINE = 1e-8


@kernel
def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def vector(array: Array, start: int) -> Vector:
    """Return three consecutive entries of a flat array."""
    return (array[start], array[start + 1], array[start + 2])


@kernel
def quaternion(array: Array, start: int) -> Quaternion:
    """Return four consecutive entries of a flat array."""
    return (array[start], array[start + 1], array[start + 2], array[start + 3])


@kernel
def store(values: Vector, array: Array, start: int) -> None:
    """Write a vector into a flat array."""
    array[start] = values[0]
    array[start + 1] = values[1]
    array[start + 2] = values[2]


@kernel
def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Hamilton product of two quaternions (w, x, y, z)."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    )


@kernel
def conjugate(q: Quaternion) -> Quaternion:
    """Inverse of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


@kernel
def rotate(q: Quaternion, v: Vector) -> Vector:
    """Turn a vector by a unit quaternion: R(q) v."""
    axis = (q[1], q[2], q[3])
    t = cross(axis, v)
    t = (2.0 * t[0], 2.0 * t[1], 2.0 * t[2])
    s = cross(axis, t)
    return (v[0] + q[0] * t[0] + s[0], v[1] + q[0] * t[1] + s[1], v[2] + q[0] * t[2] + s[2])


@kernel
def exponential(v: Vector) -> Quaternion:
    """Unit quaternion of the rotation vector v (rad)."""
    half = 0.5 * math.sqrt(dot(v, v))
    scale = 0.5 if half < SMALL_SINE else 0.5 * math.sin(half) / half
    return (math.cos(half), scale * v[0], scale * v[1], scale * v[2])


@kernel
def logarithm(q: Quaternion) -> Vector:
    """Rotation vector (rad, at most pi long) of a unit quaternion of either sign."""
    sine = math.sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    cosine = abs(q[0])
    small = sine < SMALL_SINE
    scale = choose(small, 2.0, 2.0 * math.atan2(sine, cosine) / choose(small, 1.0, sine))
    scale = choose(q[0] < 0.0, -scale, scale)
    return (scale * q[1], scale * q[2], scale * q[3])


@kernel
def product(matrix: Array, start: int, v: Vector) -> Vector:
    """Return A v where A is 3 x 3 and stands row by row in a flat array from `start`."""
    return (
        matrix[start] * v[0] + matrix[start + 1] * v[1] + matrix[start + 2] * v[2],
        matrix[start + 3] * v[0] + matrix[start + 4] * v[1] + matrix[start + 5] * v[2],
        matrix[start + 6] * v[0] + matrix[start + 7] * v[1] + matrix[start + 8] * v[2],
    )


@apart
@kernel
def inverse_dynamics(
    inertial: Array, gravity: Array, q: Quaternion, omega: Vector, a: Vector, alpha: Vector, wrench: Array
) -> None:
    """Write the wrench (6,) that accelerates the platform by `a` (of its origin) and `alpha`, world axes.

    Newton and Euler about the centre of mass G, which lies at r = R c from the origin (inertial: see `Robot`):
    force = m (a + alpha x r + omega x (omega x r) - g), moment about G = I alpha + omega x I omega; moved to the
    origin, moment = moment about G + r x force.
    """
    mass = inertial[0]
    r = rotate(q, vector(inertial, 1))
    tangential = cross(alpha, r)
    centripetal = cross(omega, cross(omega, r))
    f = (
        mass * (a[0] + tangential[0] + centripetal[0] - gravity[0]),
        mass * (a[1] + tangential[1] + centripetal[1] - gravity[1]),
        mass * (a[2] + tangential[2] + centripetal[2] - gravity[2]),
    )
    inverse = conjugate(q)
    euler = rotate(q, product(inertial, 4, rotate(inverse, alpha)))
    gyroscopic = cross(omega, rotate(q, product(inertial, 4, rotate(inverse, omega))))
    lever = cross(r, f)
    store(f, wrench, 0)
    store(
        (
            euler[0] + gyroscopic[0] + lever[0],
            euler[1] + gyroscopic[1] + lever[1],
            euler[2] + gyroscopic[2] + lever[2],
        ),
        wrench,
        3,
    )


@any_width
@kernel
def copy(source: Array, target: Array) -> None:
    """Copy the entries of a flat array."""
    for i in range(target.shape[0]):
        target[i] = source[i]
