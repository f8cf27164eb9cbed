"""Rotations outside the loop: quaternions (w, x, y, z), angles and matrices, in numpy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cdpr.base import tolerances
from cdpr.model.robot import DOF_NAMES, Array

AXES = dict(zip("xyz", np.eye(3), strict=True))
INVERSE = np.array([1.0, -1.0, -1.0, -1.0])
YZX, ZXY = np.array([1, 2, 0]), np.array([2, 0, 1])

# rad; closer to aligned axes, two Euler angles are lost in round-off.
ALIGNED = 1e-7


def multiply(a: Array, b: Array) -> Array:
    """Return the Hamilton product a b, each (4,) as w, x, y, z."""
    w, x, y, z = a.tolist()
    s, i, j, k = b.tolist()
    return np.array(  # element by element: numpy's functions take 10 times as long on three numbers
        [
            w * s - float(a[1:] @ b[1:]),
            w * i + s * x + (y * k - z * j),
            w * j + s * y + (z * i - x * k),
            w * k + s * z + (x * j - y * i),
        ]
    )


def cross(a: Array, b: Array) -> Array:
    """Return cross products (..., 3) of vectors (..., 3); faster than numpy's function for few vectors."""
    return np.asarray(a.take(YZX, -1) * b.take(ZXY, -1) - a.take(ZXY, -1) * b.take(YZX, -1))


def rotate(q: Array, vector: Array) -> Array:
    """Return a vector (3,) rotated by each of the unit quaternions (..., 4), (..., 3)."""
    twice = 2.0 * cross(q[..., 1:], np.broadcast_to(vector, (*q.shape[:-1], 3)))
    return np.asarray(vector + q[..., :1] * twice + cross(q[..., 1:], twice))


def conjugate(q: Array) -> Array:
    """Return the inverse of unit quaternions, (..., 4)."""
    return np.asarray(q * INVERSE)


def from_axis_angle(axis: Array, angle: float) -> Array:
    """Return the quaternion (4,) of a rotation by `angle` (rad) about the unit vector `axis` (3,)."""
    q = np.empty(4)  # filled in place: concatenation takes 5 times as long
    q[0] = np.cos(0.5 * angle)
    q[1:] = np.sin(0.5 * angle) * np.asarray(axis, dtype=np.float64)
    return q


def from_euler(angles: Array, order: str) -> Array:
    """Return the quaternion (4,) of successive rotations by `angles` (3,), rad.

    As in scipy, an upper-case `order` such as "XYZ" means moving axes, R = Rx Ry Rz, and a lower-case one such as "xyz"
    fixed axes, R = Rz Ry Rx.
    """
    moving = order.isupper()
    q = np.array([1.0, 0.0, 0.0, 0.0])
    for angle, axis in zip(angles, order.lower(), strict=True):
        turn = from_axis_angle(AXES[axis], float(angle))
        q = multiply(q, turn) if moving else multiply(turn, q)
    return q


def from_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """Return the quaternion (4,) of R = Rz(yaw) Ry(pitch) Rx(roll)."""
    return from_euler(np.array([roll, pitch, yaw]), "xyz")


def matrix(q: Array) -> Array:
    """Return the rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    w, x, y, z = q if np.ndim(q) == 1 else np.moveaxis(q, -1, 0)
    rows = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return rows if rows.ndim == 2 else np.moveaxis(rows, (0, 1), (-2, -1))


def rotation_vector(q: Array) -> Array:
    """Return the rotation vectors (..., 3), rad, of unit quaternions (..., 4): the shorter rotations."""
    q = np.asarray(q, dtype=np.float64)
    q = np.where(q[..., :1] < 0.0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    half = np.arctan2(sine, q[..., :1])
    scale = np.where(sine > 0.0, 2.0 * half / np.where(sine > 0.0, sine, 1.0), 2.0)
    return np.asarray(scale * q[..., 1:])


def between(a: Array, b: Array) -> Array:
    """Return rotation vectors (..., 3), rad, from the attitudes a to b, (..., 4), in their common reference axes."""
    if a.shape != b.shape:
        a, b = np.broadcast_arrays(a, b)
    p, q = (np.ascontiguousarray(np.moveaxis(each, -1, 0)) for each in (a, b))  # three times as fast for many rows
    w = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]  # the product b * conjugate(a), row by row
    crossed = cross(np.moveaxis(q[1:], 0, -1), np.moveaxis(p[1:], 0, -1))
    xyz = p[0] * q[1:] - q[0] * p[1:] - np.moveaxis(crossed, -1, 0)
    return rotation_vector(np.moveaxis(np.concatenate([w[None], xyz]), 0, -1))


def from_matrix(R: Array) -> Array:
    """Return the unit quaternion (4,) with w >= 0 of a rotation matrix (3, 3) (Shepperd's method)."""
    trace = float(np.trace(R))
    squares = np.array([trace, R[0, 0], R[1, 1], R[2, 2]])
    k = int(np.argmax(squares))
    q = np.empty(4)
    q[k] = 0.5 * np.sqrt(1.0 + 2.0 * squares[k] - trace)
    scale = 0.25 / q[k]
    if k == 0:
        q[1:] = scale * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    else:
        i, j, l = k - 1, k % 3, (k + 1) % 3  # noqa: E741
        q[0] = scale * (R[l, j] - R[j, l])
        q[1 + j] = scale * (R[j, i] + R[i, j])
        q[1 + l] = scale * (R[l, i] + R[i, l])
    return q if q[0] >= 0.0 else -q


def held_upright(dof: Sequence[str], quaternion: Array) -> bool:
    """Return True if an attitude (4,) differs from upright only about the axes in `dof`."""
    held = np.array([name not in dof for name in DOF_NAMES[3:]])
    return not held.any() or not bool((held & (np.abs(quaternion[1:]) > tolerances.HELD)).any())


def to_euler(q: Array, order: str) -> Array:
    """Return angles (3,), rad, of successive rotations of a unit quaternion (4,); the inverse of `from_euler`.

    If the middle rotation aligns the axes of the others, only their sum or difference is determined: the third is 0.
    Bernardes and Viollet, "Quaternion to Euler angles conversion", 2022.
    """
    moving = order.isupper()
    i, j, k = ("xyz".index(axis) for axis in order.lower()[:: -1 if moving else 1])
    first, last = (2, 0) if moving else (0, 2)  # as fixed axes, moving ones are in reverse order
    proper = i == k
    if proper:
        k = 3 - i - j
    sign = (i - j) * (j - k) * (k - i) // 2
    w, x = q[0], q[1:]
    if proper:
        a, b, c, d = w, x[i], x[j], sign * x[k]
    else:
        a, b, c, d = w - x[j], x[i] + sign * x[k], x[j] + w, sign * x[k] - x[i]
    angles = np.zeros(3)
    angles[1] = 2.0 * np.arctan2(np.hypot(c, d), np.hypot(a, b))
    plus, minus = np.arctan2(b, a), np.arctan2(d, c)
    if abs(angles[1]) < ALIGNED:
        angles[0] = 2.0 * plus
    elif abs(angles[1] - np.pi) < ALIGNED:
        angles[0] = 2.0 * minus * (1 if moving else -1)
    else:
        angles[first], angles[last] = plus - minus, plus + minus
    if not proper:
        angles[last] *= sign
        angles[1] -= 0.5 * np.pi
    return (angles + np.pi) % (2.0 * np.pi) - np.pi
