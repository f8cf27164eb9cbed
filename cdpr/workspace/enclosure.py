"""Numbers that depend on where in a box the platform is, enclosed: Taylor models of first order; compiled.

A model (c, x, y, z, r) says: anywhere in the box, of half sides h, where the platform is d away from the middle, the
number is c + x d_x / h_x + y d_y / h_y + z d_z / h_z, within r. What is of second order, and what arithmetic rounds
off, is in r, so that what follows from a model is proved (Makino and Berz, Int. J. Pure Appl. Math. 4, 2003).
"""

from __future__ import annotations

import math

from cdpr.model.jit import kernel

Model = tuple[float, float, float, float, float]

# Eight units in the last place: more than a sum of four rounded products errs, as a share of the sum of their sizes.
ROUNDED = 2.0**-50
# Below this a product may have lost all its digits.
LOST = 1e-290

ZERO: Model = (0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def spread(a: Model) -> float:
    """Return by how much a number changes to first order from the middle of the box."""
    return abs(a[1]) + abs(a[2]) + abs(a[3])


@kernel
def largest(a: Model) -> float:
    """Return what the size of a number is at most."""
    return (abs(a[0]) + spread(a) + a[4]) * (1.0 + ROUNDED)


@kernel
def plus(a: Model, b: Model) -> Model:
    """Return the model of a sum."""
    c, x, y, z = a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]
    r = a[4] + b[4] + ROUNDED * (abs(c) + abs(x) + abs(y) + abs(z))
    return c, x, y, z, r * (1.0 + ROUNDED)


@kernel
def times(a: Model, b: Model) -> Model:
    """Return the model of a product."""
    p, q, s, t = abs(a[0]), abs(b[0]), spread(a), spread(b)
    r = p * b[4] + q * a[4] + (s + a[4]) * (t + b[4])
    r += ROUNDED * (p * (q + t) + q * s) + LOST
    return (
        a[0] * b[0],
        a[0] * b[1] + b[0] * a[1],
        a[0] * b[2] + b[0] * a[2],
        a[0] * b[3] + b[0] * a[3],
        r * (1.0 + ROUNDED),
    )


@kernel
def scaled(a: Model, s: float) -> Model:
    """Return the model of s times a number."""
    r = abs(s) * (a[4] + ROUNDED * (abs(a[0]) + spread(a))) + LOST
    return s * a[0], s * a[1], s * a[2], s * a[3], r * (1.0 + ROUNDED)


@kernel
def inverse_distance(v: tuple[float, float, float], h: tuple[float, float, float], error: float) -> Model:
    """Return the model of 1 / |v - d|, each entry of v known to within `error`; r is infinite where it may be 1 / 0.

    The second derivative of 1 / |v| is at most 2 / |v|^3 along any direction.
    """
    length = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    half = math.sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]) * (1.0 + ROUNDED)
    near = (length * (1.0 - ROUNDED) - half - 2.0 * error) * (1.0 - ROUNDED)
    if not near > 0.0:
        return 0.0, 0.0, 0.0, 0.0, math.inf
    c = 1.0 / length
    cube = c * c * c
    x, y, z = cube * v[0] * h[0], cube * v[1] * h[1], cube * v[2] * h[2]
    far = 1.0 / near
    r = half * half * far * far * far + 2.0 * error * far * far * (1.0 + 2.0 * half * far)
    r += 2.0 * ROUNDED * (c + abs(x) + abs(y) + abs(z)) + LOST
    return c, x, y, z, r * (1.0 + 4.0 * ROUNDED)
