"""The point of least norm in a polytope { x : low <= c + N x <= high }, by a dual active-set method."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.robot import Array

# A limit counts as kept within this share of the largest coordinate: the round-off of the updates.
FEASIBILITY_TOLERANCE = 1e-13

# A limit that cannot be kept but is broken by less than this share of the largest coordinate counts as kept: the
# rounding of an ill-conditioned problem whose only solution is a vertex, far below what the checks accept.
VERTEX_TOLERANCE = 1e-9

# A constraint normal whose part orthogonal to the active ones is below this share of its length depends on them.
DEPENDENCE_TOLERANCE = 1e-11

INFEASIBLE = -1
NOT_FOUND = -2


def work_size(m: int, r: int) -> int:
    """Floats that `nearest` needs as work space."""
    return 2 * r * r + 5 * r + m + 1


@kernel
def nearest(
    N: Array, r: int, c: Array, low: Array, high: Array, x: Array, point: Array, active: Array, work: Array
) -> int:
    """Write the x (r,) of least norm with low <= c + N x <= high, and point = c + N x (m,); return the steps taken.

    N is (m, >= r). `active` (m,) receives -1, 0 or 1 where a limit holds x back; the point lies exactly on those
    limits and nowhere outside. Returns INFEASIBLE, or NOT_FOUND after a number of steps that no sound problem needs.
    `work` holds 2 r^2 + 5 r + m + 1 floats.

    Goldfarb and Idnani, Mathematical Programming 27 (1983), for a Hessian of 1: with J the orthogonal and R the
    triangular factor of the active normals.
    """
    m = c.shape[0]
    J = work[: r * r].reshape(r, r)
    R = work[r * r : 2 * r * r].reshape(r, r)
    o = 2 * r * r
    d = work[o : o + r]
    z = work[o + r : o + 2 * r]
    dual = work[o + 2 * r : o + 3 * r]
    u = work[o + 3 * r : o + 4 * r]
    member = work[o + 4 * r : o + 5 * r]
    size = work[o + 5 * r : o + 5 * r + m]

    scale = 0.0
    for i in range(m):
        point[i] = c[i]
        active[i] = 0.0
        square = 0.0
        for j in range(r):
            square += N[i, j] * N[i, j]
        size[i] = math.sqrt(square)
        scale = max(scale, abs(c[i]), abs(low[i]))
    tolerance = FEASIBILITY_TOLERANCE * scale
    for j in range(r):
        x[j] = 0.0

    k = 0  # number of active constraints
    steps = 0
    limit = 10 * (r + 1) + 4 * m
    while True:
        p, worst, side = -1, 0.0, 0.0
        for i in range(m):
            if active[i] == 0.0:
                below, above = low[i] - point[i], point[i] - high[i]
                excess = max(below, above)
                if excess > tolerance:
                    if size[i] <= DEPENDENCE_TOLERANCE:  # this cable cannot be changed at all
                        if excess > VERTEX_TOLERANCE * scale:
                            return INFEASIBLE
                        continue
                    if excess > worst * size[i]:
                        p, worst = i, excess / size[i]
                        side = 1.0 if below > above else -1.0
        if p < 0:
            break
        if k == 0:
            for i in range(r):
                for j in range(r):
                    J[i, j] = 1.0 if i == j else 0.0
        u_p = 0.0
        while True:
            steps += 1
            if steps > limit:
                return NOT_FOUND
            slack = point[p] - low[p] if side > 0.0 else high[p] - point[p]
            for j in range(r):
                s = 0.0
                for i in range(r):
                    s += J[i, j] * N[p, i]
                d[j] = side * s
            square = 0.0
            for j in range(k, r):
                square += d[j] * d[j]
            for i in range(k - 1, -1, -1):
                s = d[i]
                for j in range(i + 1, k):
                    s -= R[i, j] * dual[j]
                dual[i] = s / R[i, i]
            # How far the active multipliers allow to go, and how far the constraint itself asks to go.
            partial, drop = math.inf, -1
            for j in range(k):
                if dual[j] > DEPENDENCE_TOLERANCE and u[j] < partial * dual[j]:
                    partial, drop = u[j] / dual[j], j
            independent = square > (DEPENDENCE_TOLERANCE * size[p]) ** 2
            full = -slack / square if independent else math.inf
            step = min(partial, full)
            if step == math.inf:
                if -slack > VERTEX_TOLERANCE * scale:
                    return INFEASIBLE
                active[p] = -side
                break
            for j in range(k):
                u[j] -= step * dual[j]
            u_p += step
            if independent:
                for i in range(r):
                    s = 0.0
                    for j in range(k, r):
                        s += J[i, j] * d[j]
                    z[i] = s
                    x[i] += step * s
                for i in range(m):
                    s = 0.0
                    for j in range(r):
                        s += N[i, j] * z[j]
                    point[i] += step * s
            if full <= partial:
                _add(J, R, d, k)
                u[k] = u_p
                member[k] = p
                active[p] = -side
                k += 1
                break
            active[int(member[drop])] = 0.0
            _drop(J, R, u, member, k, drop)
            k -= 1

    for i in range(m):
        s = c[i]
        for j in range(r):
            s += N[i, j] * x[j]
        if active[i] < 0.0:
            s = low[i]
        elif active[i] > 0.0:
            s = high[i]
        point[i] = min(max(s, low[i]), high[i])
    return steps


@kernel
def _add(J: Array, R: Array, d: Array, k: int) -> None:
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
def _drop(J: Array, R: Array, u: Array, member: Array, k: int, drop: int) -> None:
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
