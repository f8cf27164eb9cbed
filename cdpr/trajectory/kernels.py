"""Evaluation of a trajectory in the loop, and what is too slow without compiling before it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cdpr.model.jit import kernel
from cdpr.model.kernels import Vector, cross, dot, exponential, multiply, quaternion, rotate, store
from cdpr.model.robot import Array
from cdpr.trajectory.rotation_rates import SMALL_ANGLE

# Slack (s) in deciding that a segment has ended: times are k * step, ends are sums, and both are rounded.
ROUNDING = 1e-9


@kernel
def body_rates(phi: Vector, rate: Vector, second: Vector) -> tuple[Vector, Vector]:
    """Angular velocity and acceleration in body axes of R = exp(phi), given the derivatives of phi.

    omega = J phi' and alpha = J phi'' + J' phi' with the right Jacobian J = 1 - a [phi] + b [phi]^2,
    a = (1 - cos t) / t^2, b = (t - sin t) / t^3, t = |phi|.
    """
    square = dot(phi, phi)
    t = math.sqrt(square)
    if t < SMALL_ANGLE:
        a = 0.5 - square / 24.0 + square * square / 720.0 - square**3 / 40320.0
        b = 1.0 / 6.0 - square / 120.0 + square * square / 5040.0 - square**3 / 362880.0
        da = -1.0 / 12.0 + square / 180.0 - square * square / 6720.0
        db = -1.0 / 60.0 + square / 1260.0 - square * square / 60480.0
    else:
        sine, cosine = math.sin(t), math.cos(t)
        a = (1.0 - cosine) / square
        b = (t - sine) / (square * t)
        da = (t * sine - 2.0 * (1.0 - cosine)) / (square * square)
        db = (3.0 * sine - 2.0 * t - t * cosine) / (square * square * t)
    growth = dot(phi, rate)
    c1 = cross(phi, rate)
    c2 = cross(phi, c1)
    d1 = cross(phi, second)
    d2 = cross(phi, d1)
    e = cross(rate, c1)
    omega = (
        rate[0] - a * c1[0] + b * c2[0],
        rate[1] - a * c1[1] + b * c2[1],
        rate[2] - a * c1[2] + b * c2[2],
    )
    alpha = (
        second[0] - a * d1[0] + b * d2[0] - da * growth * c1[0] + db * growth * c2[0] + b * e[0],
        second[1] - a * d1[1] + b * d2[1] - da * growth * c1[1] + db * growth * c2[1] + b * e[1],
        second[2] - a * d1[2] + b * d2[2] - da * growth * c1[2] + db * growth * c2[2] + b * e[2],
    )
    return omega, alpha


@kernel
def polynomial(c: Array, start: int, s: float, duration: float) -> tuple[float, float, float]:
    """Value, first and second time derivative of a quintic of the share s of the duration."""
    c1, c2, c3, c4, c5 = c[start + 1], c[start + 2], c[start + 3], c[start + 4], c[start + 5]
    x = c[start] + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))))
    v = c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))
    a = 2.0 * c2 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))
    return x, v / duration, a / (duration * duration)


@kernel
def sample(segments: Array, desired: Array, time: float) -> None:
    """Write the desired motion at `time` into `desired` (19,)."""
    low, high = 0, segments.shape[0] - 1
    while low < high:  # the last segment that has begun
        middle = (low + high + 1) // 2
        if segments[middle, 0] <= time:
            low = middle
        else:
            high = middle - 1
    c = segments[low]
    duration = c[1]
    elapsed = time - c[0]
    rest = elapsed < 0.0 or elapsed > duration + ROUNDING
    s = min(max(elapsed / duration, 0.0), 1.0)
    k = 2  # a variable: a literal for each call would compile the function six times
    x, dx, ddx = polynomial(c, k, s, duration)
    k += 6
    y, dy, ddy = polynomial(c, k, s, duration)
    k += 6
    z, dz, ddz = polynomial(c, k, s, duration)
    k += 6
    f, df, ddf = polynomial(c, k, s, duration)
    k += 6
    g, dg, ddg = polynomial(c, k, s, duration)
    k += 6
    h, dh, ddh = polynomial(c, k, s, duration)
    omega, alpha = body_rates((f, g, h), (df, dg, dh), (ddf, ddg, ddh))
    q = multiply(quaternion(c, 38), exponential((f, g, h)))
    store((x, y, z), desired, 0)
    for i in range(4):
        desired[3 + i] = q[i]
    if rest:
        for i in range(7, 19):
            desired[i] = 0.0
    else:
        store((dx, dy, dz), desired, 7)
        store(rotate(q, omega), desired, 10)
        store((ddx, ddy, ddz), desired, 13)
        store(rotate(q, alpha), desired, 16)


@kernel
def sample_each(segments: Array, which: NDArray[np.int64], times: Array, desired: Array) -> None:
    """Write into each row of `desired` (K, 19) what segment `which` (K,) says at its own one of `times` (K,)."""
    for k in range(which.shape[0]):
        sample(segments[which[k] : which[k] + 1], desired[k], times[k])


@kernel
def sample_stopping(segments: Array, begin: float, duration: float, desired: Array, time: float) -> None:
    """Write the motion as `sample` does, slowed down to rest from `begin` on within `duration` (s).

    The motion is that of a time whose pace is 1 - 3 s^2 + 2 s^3, s the share of the duration: it and its first
    derivative, and so velocity and acceleration, are continuous.
    """
    s = min(max((time - begin) / duration, 0.0), 1.0)
    pace = 1.0 - s * s * (3.0 - 2.0 * s)
    change = -6.0 * s * (1.0 - s) / duration
    sample(segments, desired, min(time, begin) + duration * s * (1.0 - s * s * (1.0 - 0.5 * s)))
    for i in range(6):
        v = desired[7 + i]
        desired[7 + i] = pace * v
        desired[13 + i] = pace * pace * desired[13 + i] + change * v


@kernel
def solve_block_tridiagonal(diagonal: Array, upper: Array, b: Array) -> None:
    """Solve a symmetric positive definite system of 2 x 2 blocks; the solution replaces b (K, 2).

    diagonal (K, 2, 2) is destroyed, upper is (K - 1, 2, 2). Positive definite, it needs no pivots.
    """
    count = b.shape[0]
    for k in range(count):
        d, r = diagonal[k], b[k]
        if k > 0:
            # diagonal[k - 1] is inverted by now, b[k - 1] multiplied by it.
            u, i = upper[k - 1], diagonal[k - 1]
            for column in range(2):
                x = i[0, 0] * u[0, column] + i[0, 1] * u[1, column]
                y = i[1, 0] * u[0, column] + i[1, 1] * u[1, column]
                d[0, column] -= u[0, 0] * x + u[1, 0] * y
                d[1, column] -= u[0, 1] * x + u[1, 1] * y
            r[0] -= u[0, 0] * b[k - 1, 0] + u[1, 0] * b[k - 1, 1]
            r[1] -= u[0, 1] * b[k - 1, 0] + u[1, 1] * b[k - 1, 1]
        determinant = d[0, 0] * d[1, 1] - d[0, 1] * d[1, 0]
        d[0, 0], d[1, 1] = d[1, 1] / determinant, d[0, 0] / determinant
        d[0, 1], d[1, 0] = -d[0, 1] / determinant, -d[1, 0] / determinant
        r[0], r[1] = d[0, 0] * r[0] + d[0, 1] * r[1], d[1, 0] * r[0] + d[1, 1] * r[1]
    for k in range(count - 2, -1, -1):
        i, u = diagonal[k], upper[k]
        x = u[0, 0] * b[k + 1, 0] + u[0, 1] * b[k + 1, 1]
        y = u[1, 0] * b[k + 1, 0] + u[1, 1] * b[k + 1, 1]
        b[k, 0] -= i[0, 0] * x + i[0, 1] * y
        b[k, 1] -= i[1, 0] * x + i[1, 1] * y
