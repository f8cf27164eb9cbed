"""Nearest and extreme points of a polytope { x : low <= c + N x <= high }, by dual active-set methods."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.jit import apart, kernel, small
from cdpr.model.lanes import choose
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.tension.factors import append, back_substitute, remove
from cdpr.tension.status import INFEASIBLE, NOT_FOUND, UNSUPPORTED, Status
from cdpr.tension.verdict import VERTEX_TOLERANCE

# A limit counts as kept within this share of the largest coordinate: the round-off of the updates.
FEASIBILITY_TOLERANCE = 1e-13

# A constraint normal whose part orthogonal to the active ones is below this share of its length depends on them.
DEPENDENCE_TOLERANCE = 1e-11


@small
@kernel
def work_rows(r: int) -> int:
    """Rows of work space that `nearest` and `extreme` need."""
    return 2 * r + 8


@apart
@kernel
def nearest(N: Array, r: int, box: Array, x: Array, point: Array, active: Array, work: Array) -> int:
    """Write the x (r,) of least norm with low <= c + N x <= high, and point = c + N x (m,); return the steps taken.

    N is (m, >= r), rows that are round-off made zero, as by `reduce`; the rows of `box` (3, >= m) are c, low and high,
    of which the limits may be infinite. `active` (m,) receives -1, 0 or 1 where a limit holds x back; the point lies
    exactly on those limits and nowhere outside. Returns -INFEASIBLE, or -NOT_FOUND after a number of steps that no
    sound problem needs. `work` has at least `work_rows(r)` rows and m columns.

    Goldfarb and Idnani, Mathematical Programming 27 (1983), for a Hessian of 1: with J the orthogonal and R the
    triangular factor of the active normals.
    """
    m = point.shape[0]
    c, low, high = box[0], box[1], box[2]
    J, R = work[:r], work[r : 2 * r]
    d, z, dual, u, member = work[2 * r], work[2 * r + 1], work[2 * r + 2], work[2 * r + 3], work[2 * r + 4]
    size, count = work[2 * r + 5], work[2 * r + 6]

    for j in range(r):
        x[j] = 0.0
    count[0] = 0
    excess, scale = least(box, point, active)
    tolerance = FEASIBILITY_TOLERANCE * scale
    if excess <= tolerance:  # nothing is in the way
        return 0
    for i in range(m):
        point[i] = c[i]
    _lengths(N, r, size, m)

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
                    if size[i] == 0.0:  # x does not change this cable
                        if excess > VERTEX_TOLERANCE * scale:
                            return -INFEASIBLE
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
                return -NOT_FOUND
            slack = point[p] - low[p] if side > 0.0 else high[p] - point[p]
            for j in range(r):
                s = 0.0
                for i in range(r):
                    s += J[i, j] * N[p, i]
                d[j] = side * s
            square = 0.0
            for j in range(k, r):
                square += d[j] * d[j]
            back_substitute(R, d, dual, k)
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
                    return -INFEASIBLE
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
                append(J, R, d, k)
                u[k] = u_p
                member[k] = p
                active[p] = -side
                k += 1
                break
            active[int(member[drop])] = 0.0
            remove(J, R, u, member, k, drop)
            k -= 1

    count[0] = k
    _settle(N, r, box, x, point, active)
    return steps


@kernel
def least(box: Array, point: Array, active: Array) -> tuple[float, float]:
    """Write c, moved onto the limits beyond which it lies, into `point` (m,), and 0 into `active`; of lanes, too.

    Returns how far it was moved at most, and the largest coordinate.
    """
    c, low, high = box[0], box[1], box[2]
    scale, excess = 0.0, 0.0
    for i in range(point.shape[0]):
        active[i] = 0.0
        scale = max(scale, abs(c[i]))
        scale = choose(low[i] > -math.inf, max(scale, abs(low[i])), scale)
        excess = max(excess, low[i] - c[i], c[i] - high[i])
        point[i] = min(max(c[i], low[i]), high[i])
    return excess, scale


@apart
@kernel
def extreme(g: Array, N: Array, r: int, box: Array, x: Array, point: Array, active: Array, work: Array) -> int:
    """Write the x (r,) with low <= c + N x <= high that minimises g . x; of several, that of least norm.

    Arguments and result as for `nearest`, whose answer is where it starts: x(s) = argmin |x|^2 / 2 + s g . x is
    followed from s = 0 along its straight pieces until it stays, which for a linear program it does at a finite s
    (Mangasarian and Meyer, SIAM J. Control Optim. 17, 1979). So the answer is unique, whatever the order of the cables.
    Returns -UNSUPPORTED where g . x has no minimum; x is then where the last piece, a ray, begins.
    """
    m = point.shape[0]
    c, low, high = box[0], box[1], box[2]
    steps = nearest(N, r, box, x, point, active, work)
    if steps < 0:
        return steps
    J, R = work[:r], work[r : 2 * r]
    d, z, dual, u, member = work[2 * r], work[2 * r + 1], work[2 * r + 2], work[2 * r + 3], work[2 * r + 4]
    size, count, rotated = work[2 * r + 5], work[2 * r + 6], work[2 * r + 7]
    k = int(count[0])
    held = 0
    for i in range(m):
        if active[i] != 0.0:
            held += 1
    if held > k:  # by more limits than there are dimensions: a vertex and nothing else
        return steps
    if steps == 0:  # `nearest` had no need of them
        _lengths(N, r, size, m)
    length = 0.0
    for i in range(r):
        length = max(length, abs(g[i]))
        if k == 0:
            for j in range(r):
                J[i, j] = 1.0 if i == j else 0.0
    limit = 50 * (r + 1) + 10 * m
    for _ in range(limit):
        steps += 1
        # dx/ds = -(part of g orthogonal to the active normals), du/ds = multipliers of the other part.
        moving = 0.0
        for j in range(r):
            s = 0.0
            for i in range(r):
                s += J[i, j] * g[i]
            rotated[j] = s
            if j >= k:
                moving = max(moving, abs(s))
        back_substitute(R, rotated, dual, k)
        step, drop, p, side = math.inf, -1, -1, 0.0
        for j in range(k):
            if dual[j] < -DEPENDENCE_TOLERANCE * length and u[j] < -step * dual[j]:
                step, drop = max(u[j], 0.0) / -dual[j], j
        if moving > DEPENDENCE_TOLERANCE * length:
            for i in range(r):
                s = 0.0
                for j in range(k, r):
                    s -= J[i, j] * rotated[j]
                z[i] = s
            for i in range(m):
                if active[i] == 0.0:
                    rate = 0.0
                    for j in range(r):
                        rate += N[i, j] * z[j]
                    if abs(rate) > DEPENDENCE_TOLERANCE * size[i] * moving:
                        room = high[i] - point[i] if rate > 0.0 else point[i] - low[i]
                        if room < step * abs(rate):
                            step, p, side = max(room, 0.0) / abs(rate), i, (1.0 if rate < 0.0 else -1.0)
        else:
            for i in range(r):
                z[i] = 0.0
        if step == math.inf:
            _correct(N, r, box, x, active, work)
            _settle(N, r, box, x, point, active)
            return -UNSUPPORTED if moving > DEPENDENCE_TOLERANCE * length else steps
        for j in range(k):
            u[j] += step * dual[j]
        for i in range(r):
            x[i] += step * z[i]
        for i in range(m):
            if active[i] == 0.0:
                s = c[i]
                for j in range(r):
                    s += N[i, j] * x[j]
                point[i] = s
        if p >= 0:
            for j in range(r):
                s = 0.0
                for i in range(r):
                    s += J[i, j] * N[p, i]
                d[j] = side * s
            append(J, R, d, k)
            u[k] = 0.0
            member[k] = p
            active[p] = -side
            point[p] = low[p] if side > 0.0 else high[p]
            k += 1
        else:
            active[int(member[drop])] = 0.0
            remove(J, R, u, member, k, drop)
            k -= 1
        count[0] = k
    return -NOT_FOUND


@kernel
def _lengths(N: Array, r: int, size: Array, m: int) -> None:
    """Write the lengths of the first m rows of N."""
    for i in range(m):
        square = 0.0
        for j in range(r):
            square += N[i, j] * N[i, j]
        size[i] = math.sqrt(square)


@kernel
def _settle(N: Array, r: int, box: Array, x: Array, point: Array, active: Array) -> None:
    """Write the point of x, exactly on the active limits and nowhere outside."""
    low, high = box[1], box[2]
    for i in range(point.shape[0]):
        s = box[0, i]
        for j in range(r):
            s += N[i, j] * x[j]
        if active[i] < 0.0:
            s = low[i]
        elif active[i] > 0.0:
            s = high[i]
        point[i] = min(max(s, low[i]), high[i])


@kernel
def _correct(N: Array, r: int, box: Array, x: Array, active: Array, work: Array) -> None:
    """Move x onto the active limits, from which many steps may have led it by some round-off."""
    J, R, y, member = work[:r], work[r : 2 * r], work[2 * r], work[2 * r + 4]
    k = int(work[2 * r + 6, 0])
    for j in range(k):  # R^T y = what each active limit lacks
        i = int(member[j])
        s = -box[0, i]
        for q in range(r):
            s -= N[i, q] * x[q]
        s = s + box[1, i] if active[i] < 0.0 else -(s + box[2, i])
        for q in range(j):
            s -= R[q, j] * y[q]
        y[j] = s / R[j, j]
    for i in range(r):
        for j in range(k):
            x[i] += J[i, j] * y[j]


def nearest_point(basis: ArrayLike, center: ArrayLike, low: ArrayLike, high: ArrayLike) -> tuple[Array, Array, Status]:
    """Compute the x of least 2-norm with low <= c + N x <= high.

    Goldfarb and Idnani, Mathematical Programming 27 (1983).

    Args:
        basis: (m, r), N. Rows that are round-off must be zero.
        center: (m,), c.
        low: (m,), may be -inf.
        high: (m,), may be inf.

    Returns:
        x (r,) and c + N x (m,), which lies exactly on the limits that hold x back; NaN unless the status is OK. The
        status: OK, INFEASIBLE where there is no such x, or NOT_FOUND.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> nearest_point([[1.0], [1.0]], [0.0, 0.0], [1.0, 2.0], [5.0, 5.0])
        (array([2.]), array([2., 2.]), <Status.OK: 0>)
    """
    return _point("nearest_point", basis, (center, low, high))


def extreme_point(
    objective: ArrayLike, basis: ArrayLike, center: ArrayLike, low: ArrayLike, high: ArrayLike
) -> tuple[Array, Array, Status]:
    """Compute the x with low <= c + N x <= high that minimises g . x; of several, that of least 2-norm.

    Mangasarian and Meyer, SIAM Journal on Control and Optimization 17 (1979).

    Args:
        objective: (r,), g.
        basis: (m, r), N. Rows that are round-off must be zero.
        center: (m,), c.
        low: (m,), may be -inf.
        high: (m,), may be inf.

    Returns:
        As `nearest_point`; the status is UNSUPPORTED where g . x has no minimum.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> extreme_point([-1.0], [[1.0], [1.0]], [0.0, 0.0], [1.0, 2.0], [5.0, 4.0])
        (array([4.]), array([4., 4.]), <Status.OK: 0>)
    """
    return _point("extreme_point", basis, (center, low, high), objective=np.array(objective, dtype=np.float64))


def _point(
    operation: str, basis: ArrayLike, rows: tuple[ArrayLike, ArrayLike, ArrayLike], **more: Array
) -> tuple[Array, Array, Status]:
    N, box = np.ascontiguousarray(basis, dtype=np.float64), np.array(rows, dtype=np.float64)
    x, point = np.empty(N.shape[1:]), np.empty(box.shape[1])
    written = {"x": x, "point": point, "active": np.empty(box.shape[1]), "steps": np.empty(1)}
    status = Status(bind(operation, basis=N, box=box, **written, **more)())
    if status != Status.OK:
        x[:] = point[:] = np.nan
    return x, point, status
