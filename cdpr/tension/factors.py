"""Triangular factors of a growing and shrinking set of vectors: the columns n_j = J[:, :k] R[:k, j]."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.robot import Array


@kernel
def back_substitute(R: Array, rhs: Array, y: Array, k: int) -> None:
    """Solve R y = rhs for the leading k x k upper triangle."""
    for i in range(k - 1, -1, -1):
        s = rhs[i]
        for j in range(i + 1, k):
            s -= R[i, j] * y[j]
        y[i] = s / R[i, i]


@kernel
def append(J: Array, R: Array, d: Array, k: int) -> None:
    """Append a constraint whose normal is J d: turn columns k.. of J so that only d[k] remains."""
    r = J.shape[0]
    for j in range(r - 1, k, -1):
        a, b = d[j - 1], d[j]
        if b != 0.0:
            h = math.hypot(a, b)
            cosine, sine = a / h, b / h
            d[j - 1] = h
            for i in range(r):
                left, right = J[i, j - 1], J[i, j]
                J[i, j - 1] = cosine * left + sine * right
                J[i, j] = cosine * right - sine * left
    for i in range(k + 1):
        R[i, k] = d[i]


@kernel
def remove(J: Array, R: Array, u: Array, member: Array, k: int, drop: int) -> None:
    """Remove active constraint number `drop` of k and make R triangular again."""
    r = J.shape[0]
    for j in range(drop, k - 1):
        u[j], member[j] = u[j + 1], member[j + 1]
        for i in range(j + 2):
            R[i, j] = R[i, j + 1]
    for j in range(drop, k - 1):
        a, b = R[j, j], R[j + 1, j]
        if b != 0.0:
            h = math.hypot(a, b)
            cosine, sine = a / h, b / h
            R[j, j] = h
            for column in range(j + 1, k - 1):
                upper, lower = R[j, column], R[j + 1, column]
                R[j, column] = cosine * upper + sine * lower
                R[j + 1, column] = cosine * lower - sine * upper
            for i in range(r):
                left, right = J[i, j], J[i, j + 1]
                J[i, j] = cosine * left + sine * right
                J[i, j + 1] = cosine * right - sine * left


@kernel
def turn(N: Array, r: int, k: int, i: int, size: float, v: Array) -> None:
    """Reflect columns k to r of N so that of these only column k changes row i, which has length `size` there.

    The columns stay orthonormal. `v` is work space for r numbers.
    """
    v[k] = N[i, k] + math.copysign(size, N[i, k])
    for j in range(k + 1, r):
        v[j] = N[i, j]
    scale = 1.0 / (size * abs(v[k]))  # 2 / |v|^2
    for row in range(N.shape[0]):
        s = 0.0
        for j in range(k, r):
            s += N[row, j] * v[j]
        s *= scale
        for j in range(k, r):
            N[row, j] -= s * v[j]
    for j in range(k + 1, r):
        N[i, j] = 0.0  # but for round-off, which would let the row drift
