"""The compiled mathematics of the loop. Conventions: see `cdpr.model`.

Vectors that stay inside a kernel are tuples, which the compiler keeps in registers; arrays come in and go out.
`NUMBA_DISABLE_JIT=1` runs the same source as plain Python.
"""

from __future__ import annotations

from cdpr.model.jit import any_width, kernel
from cdpr.model.robot import Array

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


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
def rotate(q: Quaternion, v: Vector) -> Vector:
    """Turn a vector by a unit quaternion: R(q) v."""
    axis = (q[1], q[2], q[3])
    t = cross(axis, v)
    t = (2.0 * t[0], 2.0 * t[1], 2.0 * t[2])
    s = cross(axis, t)
    return (v[0] + q[0] * t[0] + s[0], v[1] + q[0] * t[1] + s[1], v[2] + q[0] * t[2] + s[2])


@any_width
@kernel
def copy(source: Array, target: Array) -> None:
    """Copy the entries of a flat array."""
    for i in range(target.shape[0]):
        target[i] = source[i]
