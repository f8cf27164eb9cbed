"""The facets of two cables more than directions, as most robots have: of one pose or eight side by side; compiled.

An elementary vector p of W's row space is then a cross product of three rows of N, without any elimination.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cdpr.model import cholesky
from cdpr.model.jit import kernel
from cdpr.model.kinds import ROW, TABLE, Group
from cdpr.model.lanes import choose
from cdpr.model.robot import Array
from cdpr.workspace.facets import DEPENDENT, ELLIPSOID, VERTICES, ZONOTOPE

TWO = 2  # cables more than directions


class Pair(NamedTuple):
    """Work space, of numbers or of lanes."""

    gram: Array  # (n, n)
    Y: Array  # (n, m), W^+^T: c = Y p
    G: Array  # (m, m), Y^T Y, its upper half
    Z: Array  # (k, m), of the required set
    off: Array  # (m,), of the least tensions, from the middle of the limits
    best: Array  # (n,), the direction of the nearest facet


PAIR = Group((TABLE, TABLE, TABLE, TABLE, ROW, ROW), Pair)


def pair_shapes(n: int, m: int, k: int) -> tuple[tuple[int, ...], ...]:
    """Return the shapes of the work space of n directions, m cables and k vectors that are required."""
    return (n, n), (n, m), (m, m), (k, m), (m,), (n,)


@kernel
def project(W: Array, required: Array, pair: Pair) -> bool:
    """Write Y = (W W^T)^-1 W, Y^T Y, and Y^T times the vectors of the required set; whether that is possible."""
    n, m = W.shape
    L, Y, G, Z = pair.gram, pair.Y, pair.G, pair.Z
    for j in range(n):
        for k in range(j + 1):
            s = W[j, 0] * W[k, 0]
            for i in range(1, m):
                s += W[j, i] * W[k, i]
            L[j, k] = s
    sound = cholesky.factorise_each(L)
    for j in range(n):
        pair.best[j] = 1.0 / L[j, j]
    for i in range(m):
        for j in range(n):
            s = W[j, i]
            for k in range(j):
                s -= L[j, k] * Y[k, i]
            Y[j, i] = s * pair.best[j]
        for j in range(n - 1, -1, -1):
            s = Y[j, i]
            for k in range(j + 1, n):
                s -= L[k, j] * Y[k, i]
            Y[j, i] = s * pair.best[j]
    for i in range(m):
        for k in range(i, m):
            s = Y[0, i] * Y[0, k]
            for j in range(1, n):
                s += Y[j, i] * Y[j, k]
            G[i, k] = s
        for g in range(required.shape[0]):
            s = required[g, 0] * Y[0, i]
            for j in range(1, n):
                s += required[g, j] * Y[j, i]
            Z[g, i] = s
    return sound


@kernel
def margin_of_two(
    form: int, W: Array, limits: Array, box: Array, N: Array, required: Array, pair: Pair, value: Array
) -> bool:
    """Write margin and scale into `value` (2,), the direction into `pair.best`; whether there are such.

    Of c = Y p only its square, from Y^T Y, and what it says of the required set, from Y times its vectors, are asked
    for, but for the least one. From the middle of all limits (2, m) the cables reach as far along c as along -c.
    """
    n, m = W.shape
    sound = project(W, required, pair)
    Y, G, Z, off = pair.Y, pair.G, pair.Z, pair.off
    low, high = limits[0], limits[1]
    for i in range(m):
        off[i] = box[0, i] - 0.5 * (low[i] + high[i])
    least, square, scale, sign = math.inf, 1.0, 0.0, 1.0
    a, b, d, pa, pb, pd = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(m - 2):
        h0 = 0.5 * (high[i] - low[i])
        for j in range(i + 1, m - 1):
            h1, g01 = 0.5 * (high[j] - low[j]), 2.0 * G[i, j]
            p2 = N[i, 0] * N[j, 1] - N[i, 1] * N[j, 0]
            size2, part2 = abs(p2), p2 * p2
            for k in range(j + 1, m):
                p0, p1 = N[j, 0] * N[k, 1] - N[j, 1] * N[k, 0], N[k, 0] * N[i, 1] - N[k, 1] * N[i, 0]
                base = p0 * off[i] + p1 * off[j] + p2 * off[k]
                reached = abs(p0) * h0 + abs(p1) * h1 + size2 * (0.5 * (high[k] - low[k]))
                length = p0 * (p0 * G[i, i] + p1 * g01) + p1 * p1 * G[j, j]
                length += p2 * (p2 * G[k, k] + 2.0 * (p0 * G[i, k] + p1 * G[j, k]))
                along = 0.0 * p0
                against = along
                for g in range(Z.shape[0]):
                    s = p0 * Z[g, i] + p1 * Z[g, j] + p2 * Z[g, k]
                    if form == ZONOTOPE:
                        along += abs(s)
                    elif form == ELLIPSOID:
                        along += s * s
                    elif g == 0:
                        along, against = s, -s
                    else:
                        along, against = max(along, s), max(against, -s)
                if form == ELLIPSOID:
                    along = math.sqrt(along)
                if form != VERTICES:
                    against = along
                over, under = -base - along, base - against
                margin = reached + min(over, under)
                # Which of margin / sqrt(length) is less, without roots and quotients.
                nearer = margin * abs(margin) * square < least * abs(least) * length
                nearer = nearer & (p0 * p0 + p1 * p1 + part2 > DEPENDENT * DEPENDENT)
                least, square = choose(nearer, margin, least), choose(nearer, length, square)
                scale = choose(nearer, reached + abs(base) + along, scale)
                sign = choose(nearer, choose(over < under, 1.0, -1.0), sign)
                a, b, d = choose(nearer, 1.0 * i, a), choose(nearer, 1.0 * j, b), choose(nearer, 1.0 * k, d)
                pa, pb, pd = choose(nearer, p0, pa), choose(nearer, p1, pb), choose(nearer, p2, pd)
    length = math.sqrt(square)
    for q in range(n):
        s = 0.0 * length
        for i in range(m):
            s += Y[q, i] * choose(a == i, pa, choose(b == i, pb, choose(d == i, pd, 0.0)))
        pair.best[q] = sign * s / length
    value[0], value[1] = least / length, scale / length
    return sound & (square > 0.0)


@kernel
def closure_of_two(N: Array) -> float:
    """Return by how much the least elementary vector, of unit length, has both signs; negative where it has one."""
    m, least, square = N.shape[0], math.inf, 1.0
    for i in range(m - 2):
        for j in range(i + 1, m - 1):
            p2 = N[i, 0] * N[j, 1] - N[i, 1] * N[j, 0]
            for k in range(j + 1, m):
                p0, p1 = N[j, 0] * N[k, 1] - N[j, 1] * N[k, 0], N[k, 0] * N[i, 1] - N[k, 1] * N[i, 0]
                size = p0 * p0 + p1 * p1 + p2 * p2
                value = min(max(p0, max(p1, p2)), -min(p0, min(p1, p2)))
                # Which of value / sqrt(size) is less, without roots and quotients.
                less = value * abs(value) * square < least * abs(least) * size
                less = less & (size > DEPENDENT * DEPENDENT)
                least, square = choose(less, value, least), choose(less, size, square)
    return least / math.sqrt(square)
