"""Statics and clearances at one position in rational arithmetic: nothing is rounded, square roots are enclosed."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

import numpy as np

GUARD_BITS = 110  # a square root has at least so many bits, 33 digits


def root(square: Fraction) -> tuple[Fraction, Fraction]:
    """Return numbers below and above a square root, both above 0 where it is, with more than 32 digits in common."""
    shift = GUARD_BITS + max(0, square.denominator.bit_length() - square.numerator.bit_length()) // 2
    low = isqrt((square.numerator << 2 * shift) // square.denominator)
    return Fraction(low, 1 << shift), Fraction(low + 1, 1 << shift)


def turned(q, vector):
    """Return R(q) v for the normalised quaternion."""
    w, x, y, z = map(Fraction, q)
    size = w * w + x * x + y * y + z * z
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return [sum(a * Fraction(b) for a, b in zip(row, vector, strict=True)) / size for row in rows]


def cross(a, b):
    return [a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3] for k in range(3)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def columns(robot, position, q):
    """Return [v; b x v] of all cables, v from the platform to the frame: W times the lengths; and squared lengths."""
    found, squares = [], []
    for anchor in robot.anchors.tolist():
        b = turned(q, anchor[3:])
        v = [Fraction(a) - p - c for a, p, c in zip(anchor[:3], position, b, strict=True)]
        six = [*v, *cross(b, v)]
        found.append([six[row] for row in robot.rows])
        squares.append(dot(v, v))
    return found, squares


def solved(rows, right):
    """Return x with rows x = right, by elimination."""
    n = len(right)
    table = [[*row, value] for row, value in zip(rows, right, strict=True)]
    for k in range(n):
        at = max(range(k, n), key=lambda i: abs(table[i][k]))
        table[k], table[at] = table[at], table[k]
        for i in range(k + 1, n):
            factor = table[i][k] / table[k][k]
            table[i] = [a - factor * b for a, b in zip(table[i], table[k], strict=True)]
    x = [Fraction(0)] * n
    for k in range(n - 1, -1, -1):
        x[k] = (table[k][n] - dot(table[k][k + 1 : n], x[k + 1 :])) / table[k][k]
    return x


def holds(robot, position, q, wrench, tension):
    """Return True if tensions near those given, (m,), exactly balance a wrench (n,) of rationals, within the limits.

    Of n cables the tensions are solved for, those of the others are as given; where they then are within the limits, it
    is proved that there are such. False proves nothing.
    """
    full, squares = columns(robot, position, q)
    low, high = robot.tension_min.tolist(), robot.tension_max.tolist()
    W = np.array([[float(each) for each in column] for column in full]).T
    slack = np.minimum(tension - robot.tension_min, robot.tension_max - tension)
    chosen = []
    for i in np.argsort(-slack).tolist():  # those farthest from their limits, as long as they are independent
        if len(chosen) < robot.n and np.linalg.svd(W[:, [*chosen, i]], compute_uv=False)[-1] > 1e-6:
            chosen.append(i)
    given = {i: Fraction(float(tension[i])) / root(squares[i])[0] for i in range(robot.m) if i not in chosen}
    right = [w - sum(full[i][j] * given[i] for i in given) for j, w in enumerate(wrench)]
    free = solved([[full[i][j] for i in chosen] for j in range(robot.n)], right)
    shares = given | dict(zip(chosen, free, strict=True))
    for i, share in shares.items():
        near, far = root(squares[i])
        if not (share >= 0 and share * near >= Fraction(low[i]) and share * far <= Fraction(high[i])):
            return False
    return True


def beyond(robot, position, q, wrench, c):
    """Return True if c (n,) proves that no tensions within limits >= 0 balance a wrench (n,): c . w > max c . W t."""
    full, squares = columns(robot, position, q)
    c = [Fraction(float(each)) for each in c]
    most = Fraction(0)
    for i, column in enumerate(full):
        along, (near, far) = dot(c, column), root(squares[i])
        limit = Fraction(float(robot.tension_max[i] if along > 0 else robot.tension_min[i]))
        most += limit * along / (near if along > 0 else far)
    return dot(c, wrench) > most


def gap(a, b, c, d):
    """Return the squared distance of segments a b and c d."""
    u, v, w = ([y - x for x, y in zip(s, e, strict=True)] for s, e in ((a, b), (c, d), (c, a)))
    found = []

    def at(s, t):
        found.append(sum((k + s * p - t * r) ** 2 for k, p, r in zip(w, u, v, strict=True)))

    uu, uv, vv, uw, vw = dot(u, u), dot(u, v), dot(v, v), dot(u, w), dot(v, w)
    clip = lambda x: min(max(x, Fraction(0)), Fraction(1))  # noqa: E731
    for end in (Fraction(0), Fraction(1)):
        at(end, clip((uv * end + vw) / vv))
        at(clip((uv * end - uw) / uu), end)
    if uu * vv != uv * uv:
        s = (uv * vw - vv * uw) / (uu * vv - uv * uv)
        t = (uu * vw - uv * uw) / (uu * vv - uv * uv)
        if 0 <= s <= 1 and 0 <= t <= 1:
            at(s, t)
    return min(found)


def cables(robot, position, q):
    """Return the ends of all cables."""
    ends = []
    for anchor in robot.anchors.tolist():
        b = turned(q, anchor[3:])
        ends.append(([Fraction(a) for a in anchor[:3]], [p + x for p, x in zip(position, b, strict=True)]))
    return ends
