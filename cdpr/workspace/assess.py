"""What the cables can do at one pose, and at many: compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.mechanics import geometry
from cdpr.model import cholesky, kernels
from cdpr.model.jit import DISABLED, apart, kernel, threaded_kernel
from cdpr.model.kinds import CUBE, INDICES, NOTHING, ROW, TABLE, TRUTH, WHOLE, Group
from cdpr.model.lanes import WIDTH, side_by_side
from cdpr.model.robot import Array
from cdpr.tension import null_space
from cdpr.tension.status import INFEASIBLE, NOT_FOUND
from cdpr.workspace.facets import DEPENDENT, next_subset, orthogonal

# What is asked.
MARGIN, CLOSURE, PAYLOAD = range(3)

# Forms of sets of required wrenches, as `cdpr.workspace.required.FORMS`.
ZONOTOPE, ELLIPSOID, VERTICES = range(3)

# What is said of a pose.
REGULAR, SINGULAR, BAD = range(3)

# Share of the largest number that a margin is the difference of, below which its sign is round-off: the pose counts as
# on the boundary.
ROUNDING = 1e-9


def _as_they_are(rows: Array) -> Array:
    return rows.reshape(rows.shape[0], rows.shape[1] * rows.shape[2])


# Rows of cables as rows of eight cables each; in Python as they are.
beside = _as_they_are if DISABLED else side_by_side


class Asked(NamedTuple):
    """What is asked of all poses."""

    mode: int
    lines: Array  # (m, 6 or more), as `cdpr.cables.lines` says
    limits: Array  # (2, m), N
    rows: NDArray[np.int64]  # (n,), degrees of freedom: rows of a wrench
    weights: Array  # (n,), 1, and for moments 1 / characteristic length
    inertial: Array  # (13,), as `Robot.inertial`
    gravity: Array  # (3,), m/s^2
    form: int
    vectors: Array  # (k, 6), of the required set
    accelerations: bool  # whether they are such


class Found(NamedTuple):
    """What is found of K poses."""

    poses: Array  # (K, 7), given: position (m) and unit quaternion w, x, y, z
    value: Array  # (K,), margin, N; closure, 1 or -1; payload, kg
    scale: Array  # (K,), of `value`: times ROUNDING, what round-off may make of it
    direction: Array  # (K, n), unit, in which the margin is least, moments divided by the characteristic length
    status: NDArray[np.int64]  # (K,)


ASKED = Group((WHOLE, TABLE, TABLE, INDICES, ROW, ROW, ROW, WHOLE, TABLE, TRUTH), Asked)
FOUND = Group((TABLE, ROW, ROW, TABLE, INDICES), Found)


class Space(NamedTuple):
    """Work space for n directions and m cables, one for each thread."""

    W: Array  # (n, m)
    wrench: Array  # (n,)
    load: Array  # (n,), what carries 1 kg at the centre of mass
    required: Array  # (k, n)
    box: Array  # (3, m)
    N: Array  # (m, m)
    Y: Array  # (n, m or more): c = Y p, p of the free cables
    gram: Array  # (n, n)
    free: NDArray[np.int64]  # (m,), cables whose tension is not given by their limits
    chosen: NDArray[np.int64]  # (m,), a subset of those
    A: Array  # (m + n, m + n)
    G: Array  # (m, m or more), Y^T Y
    Z: Array  # (k, m or more), Y^T times the vectors of the required set
    wide_y: Array  # (n, m / 8, 8), Y, as are the next two G and Z
    wide_g: Array
    wide_z: Array
    B: Array  # (4, m), of the free cables: N, least tensions from the middle of the limits, half their width
    x: Array  # (m + n,)
    p: Array  # (m,)
    c: Array  # (n,)
    best: Array  # (n,)
    work: Array
    state: Array  # (13,), at rest
    W6: Array  # (6, m)
    six: Array  # (6,)
    value: Array  # (2,), and its scale


SPACE = Group(
    (
        *(TABLE, ROW, ROW, TABLE, TABLE, TABLE, TABLE, TABLE, INDICES, INDICES, TABLE, TABLE, TABLE),
        *(CUBE, CUBE, CUBE, TABLE, ROW, ROW, ROW, ROW, TABLE, ROW, TABLE, ROW, ROW),
    ),
    Space,
)


@kernel
def reach(form: int, required: Array, c: Array, n: int) -> tuple[float, float]:
    """Return how far the required set (k, >= n) reaches along c (n,), and along -c."""
    ahead, behind = 0.0, 0.0
    for k in range(required.shape[0]):
        s = 0.0
        for j in range(n):
            s += c[j] * required[k, j]
        if form == VERTICES:
            ahead = s if k == 0 else max(ahead, s)
            behind = -s if k == 0 else max(behind, -s)
        elif form == ELLIPSOID:
            ahead += s * s
        else:
            ahead += abs(s)
    if form == ELLIPSOID:
        ahead = math.sqrt(ahead)
    return ahead, (behind if form == VERTICES else ahead)


@kernel
def facets(mode: int, form: int, low: Array, high: Array, count: int, r: int, space: Space) -> tuple[float, float]:
    """Return the value of one pose, and its scale, from N, c in `box[0]`, W and the `count` free cables in `space`.

    Of a margin, `space.best` (n,) receives the direction.
    """
    n, W, N, box, Y = space.wrench.shape[0], space.W, space.N, space.box, space.Y
    index, free, A, x, p, c = space.chosen, space.free, space.A, space.x, space.p, space.c
    dual = r < n - 1
    several = r + 1 if dual else n - 1
    least, scale, lightest, heaviest, lightest_scale = math.inf, 0.0, -math.inf, math.inf, 0.0
    for k in range(several):
        index[k] = k
    going = True
    while going:
        if dual:
            for j in range(r):
                for k in range(several):
                    A[j, k] = N[free[index[k]], j]
            sound = orthogonal(A, r, x)
        else:
            for k in range(several):
                size = 0.0
                for j in range(n):
                    size += W[j, free[index[k]]] ** 2
                size = math.sqrt(size)
                for j in range(n):
                    A[k, j] = W[j, free[index[k]]] / size
            sound = orthogonal(A, n - 1, c)
            if sound:
                for i in range(count):
                    p[i] = 0.0
                    for j in range(n):
                        p[i] += c[j] * W[j, free[i]]
                for k in range(several):
                    p[index[k]] = 0.0
        if sound:
            base, ahead, behind, size, largest, smallest = 0.0, 0.0, 0.0, 0.0, -math.inf, math.inf
            for k in range(several if dual else count):
                i = free[index[k]] if dual else free[k]
                value = x[k] if dual else p[k]
                up, down = value * high[i], value * low[i]
                base += value * box[0, i]
                ahead += max(up, down)
                behind += min(up, down)
                size = max(size, max(abs(up), abs(down)))
                if dual or value != 0.0:
                    largest, smallest = max(largest, value), min(smallest, value)
            if mode == CLOSURE:
                # Of one sign, p is what a twist does that slackens cables and stretches none (Stiemke's lemma).
                least = min(least, min(largest, -smallest))
                scale = 1.0
            else:
                if dual:
                    for j in range(n):
                        c[j] = 0.0
                        for k in range(several):
                            c[j] += x[k] * Y[j, index[k]]
                along, against = reach(form, space.required, c, n)
                length = 0.0
                for j in range(n):
                    length += c[j] * c[j]
                length = math.sqrt(length)
                over, under = ahead - base - along, base - behind - against
                if mode == PAYLOAD:
                    pull = 0.0
                    for j in range(n):
                        pull += c[j] * space.load[j]
                    if abs(pull) > ROUNDING * length:
                        first, second = over / pull, -under / pull
                        most, fewest = max(first, second), min(first, second)
                        rounding = (max(size, abs(base)) + along) / abs(pull)
                        if most < heaviest:
                            heaviest, scale = most, rounding
                        if fewest > lightest:
                            lightest, lightest_scale = fewest, rounding
                    elif min(over, under) < -ROUNDING * (max(size, abs(base)) + along):
                        heaviest = -math.inf
                else:
                    margin = min(over, under) / length
                    if margin < least:
                        least = margin
                        scale = (max(size, abs(base)) + along) / length
                        for j in range(n):
                            space.best[j] = (c[j] if over < under else -c[j]) / length
        going = next_subset(index, several, count)
    if mode == PAYLOAD:
        return (heaviest if lightest <= ROUNDING * lightest_scale and lightest <= heaviest else math.nan), scale
    return least, scale


@kernel
def facets_of_two(form: int, count: int, space: Space) -> tuple[float, float]:
    """Return margin and scale as `facets` does, of a redundancy of two: without the normals, but for the least one.

    p on the cables i, j, k is a cross product of columns of N. Of c = Y^T p only its square, from Y Y^T in `space.A`,
    and what it says of the required set, from Y times its vectors in `space.Z`, are asked for. From the middle of all
    limits the cables reach as far along c as along -c.
    """
    Y, G, Z, B = space.Y, space.G, space.Z, space.B
    X, V, C, H = B[0], B[1], B[2], B[3]
    vectors, n = space.required.shape[0], space.wrench.shape[0]
    least, square, scale, sign = math.inf, 1.0, 0.0, 1.0
    a, b, d, pa, pb, pd = 0, 0, 0, 0.0, 0.0, 0.0
    for i in range(count - 2):
        x0, y0, c0, h0, g0 = X[i], V[i], C[i], H[i], G[i, i]
        for j in range(i + 1, count - 1):
            x1, y1, p2 = X[j], V[j], x0 * V[j] - y0 * X[j]
            c1, h1, g1, g01, size2 = C[j], H[j], G[j, j], 2.0 * G[i, j], abs(p2)
            for k in range(j + 1, count):
                p0, p1 = x1 * V[k] - y1 * X[k], X[k] * y0 - V[k] * x0
                if not p0 * p0 + p1 * p1 + p2 * p2 > DEPENDENT * DEPENDENT:
                    continue
                base = p0 * c0 + p1 * c1 + p2 * C[k]
                reached = abs(p0) * h0 + abs(p1) * h1 + size2 * H[k]
                length = p0 * (p0 * g0 + p1 * g01) + p1 * p1 * g1
                length += p2 * (p2 * G[k, k] + 2.0 * (p0 * G[i, k] + p1 * G[j, k]))
                along, against = 0.0, 0.0
                for g in range(vectors):
                    s = p0 * Z[g, i] + p1 * Z[g, j] + p2 * Z[g, k]
                    if form == ZONOTOPE:
                        along += abs(s)
                    elif form == ELLIPSOID:
                        along += s * s
                    else:
                        along = s if g == 0 else max(along, s)
                        against = -s if g == 0 else max(against, -s)
                if form == ELLIPSOID:
                    along = math.sqrt(along)
                if form != VERTICES:
                    against = along
                margin = reached + min(-base - along, base - against)
                # Which of margin / sqrt(length) is less, without roots and quotients.
                if margin * abs(margin) * square < least * abs(least) * length or least == math.inf:
                    least, square, sign = margin, length, 1.0 if -base - along < base - against else -1.0
                    scale = reached + abs(base) + along
                    a, b, d, pa, pb, pd = i, j, k, p0, p1, p2
    length = math.sqrt(square)
    for q in range(n):
        space.best[q] = sign * (pa * Y[q, a] + pb * Y[q, b] + pd * Y[q, d]) / length
    return least / length, scale / length


@apart
@kernel
def closure_of_two(count: int, N: Array, free: NDArray[np.int64]) -> float:
    """Return the value of a closure as `facets` does, of a redundancy of two: p on three cables is a cross product."""
    least, square = math.inf, 1.0
    for i in range(count - 2):
        x0, y0 = N[free[i], 0], N[free[i], 1]
        for j in range(i + 1, count - 1):
            x1, y1 = N[free[j], 0], N[free[j], 1]
            p2 = x0 * y1 - y0 * x1
            for k in range(j + 1, count):
                x2, y2 = N[free[k], 0], N[free[k], 1]
                p0, p1 = x1 * y2 - y1 * x2, x2 * y0 - y2 * x0
                size = p0 * p0 + p1 * p1 + p2 * p2
                if size > DEPENDENT * DEPENDENT:
                    value = min(max(p0, max(p1, p2)), -min(p0, min(p1, p2)))
                    # Which of value / sqrt(size) is less, without roots and quotients.
                    if value * abs(value) * square < least * abs(least) * size or least == math.inf:
                        least, square = value, size
    return least / math.sqrt(square)


@kernel
def invert(count: int, space: Space) -> bool:
    """Write Y = (W W^T)^-1 W of the free cables, eight of them side by side; whether that is possible."""
    n, W, L, Y, wide = space.wrench.shape[0], space.W, space.gram, space.Y, beside(space.wide_y)
    inverse = space.c
    for j in range(n):
        for i in range(count):
            Y[j, i] = W[j, space.free[i]]
        for i in range(count, Y.shape[1]):
            Y[j, i] = 0.0
    for j in range(n):
        for k in range(j + 1):
            s = 0.0
            for i in range(count):
                s += Y[j, i] * Y[k, i]
            L[j, k] = s
    if not cholesky.factorise(L, 0.0):
        return False
    for j in range(n):
        inverse[j] = 1.0 / L[j, j]
    for b in range(wide.shape[1]):
        for j in range(n):
            y = wide[j, b]
            for k in range(j):
                y = y - L[j, k] * wide[k, b]
            wide[j, b] = y * inverse[j]
        for j in range(n - 1, -1, -1):
            y = wide[j, b]
            for k in range(j + 1, n):
                y = y - L[k, j] * wide[k, b]
            wide[j, b] = y * inverse[j]
    return True


@kernel
def project(count: int, space: Space) -> None:
    """Write Y^T Y of the free cables, and Y^T times the vectors of the required set, eight cables side by side."""
    n, required = space.wrench.shape[0], space.required
    Y, G, Z = beside(space.wide_y), beside(space.wide_g), beside(space.wide_z)
    for b in range(Y.shape[1]):
        for i in range(count):
            s = 0.0 * Y[0, b]
            for j in range(n):
                s = s + space.Y[j, i] * Y[j, b]
            G[i, b] = s
        for k in range(required.shape[0]):
            s = 0.0 * Y[0, b]
            for j in range(n):
                s = s + required[k, j] * Y[j, b]
            Z[k, b] = s


@kernel
def look(asked: Asked, pose: Array, space: Space) -> int:
    """Write value and scale of one pose into `space.value`, the direction into `space.best`; return what is said."""
    lines, rows, weights = asked.lines, asked.rows, asked.weights
    state, W6, six, value = space.state, space.W6, space.six, space.value
    n, m = rows.shape[0], lines.shape[0]
    low, high = asked.limits[0], asked.limits[1]
    still = (0.0, 0.0, 0.0)
    for i in range(7):
        state[i] = pose[i]
    geometry.cable_geometry(lines, state, W6, space.p, space.p)
    q = kernels.quaternion(state, 3)
    kernels.inverse_dynamics(asked.inertial, asked.gravity, q, still, still, still, six)
    for j in range(n):
        space.wrench[j] = weights[j] * six[rows[j]]
        space.best[j] = math.nan
        # Of 1 kg where the platform's own mass is.
        space.load[j] = space.wrench[j] / asked.inertial[0]
        for i in range(m):
            space.W[j, i] = weights[j] * W6[rows[j], i]
    for k in range(asked.vectors.shape[0]):
        v = asked.vectors[k]
        for j in range(6):
            six[j] = v[j]
        if asked.accelerations:
            kernels.inverse_dynamics(
                asked.inertial, state[10:13], q, still, kernels.vector(v, 0), kernels.vector(v, 3), six
            )
        for j in range(n):
            space.required[k, j] = weights[j] * six[rows[j]]
    value[0], value[1] = math.nan, 1.0
    r = null_space.reduce(space.W, space.wrench, low, high, space.box, space.N, space.work)
    if r in (-INFEASIBLE, -NOT_FOUND):
        return SINGULAR
    if r < 0:
        return BAD
    count = 0
    for i in range(m):
        if low[i] < high[i]:
            space.free[count] = i
            count += 1
    if count - r < n:
        return SINGULAR
    if asked.mode != CLOSURE and r < n - 1 and not invert(count, space):
        return SINGULAR
    if asked.mode == MARGIN and r == 2 and n > 3:
        for i in range(count):
            f = space.free[i]
            space.B[0, i], space.B[1, i] = space.N[f, 0], space.N[f, 1]
            space.B[2, i], space.B[3, i] = space.box[0, f] - 0.5 * (low[f] + high[f]), 0.5 * (high[f] - low[f])
        project(count, space)
        value[0], value[1] = facets_of_two(asked.form, count, space)
        return REGULAR
    if asked.mode == CLOSURE and r == 2 and n > 3:
        value[0], value[1] = closure_of_two(count, space.N, space.free), 1.0
        return REGULAR
    value[0], value[1] = facets(asked.mode, asked.form, low, high, count, r, space)
    return REGULAR


def space_for(asked: Asked) -> Space:
    """Return work space for one thread."""
    n, m, k = len(asked.rows), len(asked.lines), len(asked.vectors)
    size, wide = m + n + 1, (m + WIDTH - 1) // WIDTH
    Y, G, Z = np.empty((n, wide, WIDTH)), np.empty((m, wide, WIDTH)), np.empty((k, wide, WIDTH))
    return Space(
        np.empty((n, m)),
        np.empty(n),
        np.empty(n),
        np.empty((k, n)),
        np.empty((3, m)),
        np.empty((m, m)),
        Y.reshape(n, wide * WIDTH),
        np.empty((n, n)),
        np.empty(m, np.int64),
        np.empty(size, np.int64),
        np.empty((size, size)),
        G.reshape(m, wide * WIDTH),
        Z.reshape(k, wide * WIDTH),
        Y,
        G,
        Z,
        np.empty((4, m)),
        np.empty(size),
        np.empty(m),
        np.empty(n),
        np.empty(n),
        np.empty((n + 5, max(n, m))),
        np.zeros(13),
        np.empty((6, m)),
        np.empty(6),
        np.empty(2),
    )


@threaded_kernel(NOTHING(ASKED, FOUND, SPACE))
def assess(asked: Asked, found: Found, space: Space) -> None:
    """Write what is found of all poses."""
    for k in range(found.poses.shape[0]):
        found.status[k] = look(asked, found.poses[k], space)
        found.value[k], found.scale[k] = space.value[0], space.value[1]
        for j in range(asked.rows.shape[0]):
            found.direction[k, j] = space.best[j]
