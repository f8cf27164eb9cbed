"""Evaluation of a trajectory in the loop."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.kernels import Vector, cross, dot, exponential, multiply, quaternion, rotate, store
from cdpr.model.robot import Array

# Below this angle (rad) the coefficients are summed as series, of which the first term left out is below 1e-14.
SMALL_ANGLE = 0.05

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
