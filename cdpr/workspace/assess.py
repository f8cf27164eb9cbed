"""What the cables can do at one pose, and at many: compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.mechanics import geometry
from cdpr.model import cholesky, kernels
from cdpr.model.jit import kernel
from cdpr.model.kinds import INDICES, ROW, TABLE, TRUTH, WHOLE, Group
from cdpr.model.robot import Array
from cdpr.tension import null_space
from cdpr.tension.status import INFEASIBLE, NOT_FOUND
from cdpr.workspace.facets import ELLIPSOID, VERTICES, next_subset, orthogonal
from cdpr.workspace.redundancy_two import PAIR, TWO, Pair, closure_of_two, margin_of_two, pair_shapes

# What is asked.
MARGIN, CLOSURE, PAYLOAD = range(3)

# What is said of a pose.
REGULAR, SINGULAR, BAD = range(3)

# Share of the largest number that a margin is the difference of, below which its sign is round-off: the pose counts as
# on the boundary.
ROUNDING = 1e-9


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
    nothing: Array  # (3,), zeros


ASKED = Group((WHOLE, TABLE, TABLE, INDICES, ROW, ROW, ROW, WHOLE, TABLE, TRUTH, ROW), Asked)


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
    pair: Pair
    x: Array  # (m + n,)
    p: Array  # (m + n,)
    c: Array  # (n,)
    best: Array  # (n,)
    work: Array
    state: Array  # (13,), at rest
    W6: Array  # (6, m)
    six: Array  # (6,)
    value: Array  # (2,), and its scale


SPACE = Group(
    (
        *(TABLE, ROW, ROW, TABLE, TABLE, TABLE, TABLE, TABLE, INDICES, INDICES, TABLE, PAIR),
        *(ROW, ROW, ROW, ROW, TABLE, ROW, TABLE, ROW, ROW),
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
def invert(count: int, space: Space) -> bool:
    """Write Y = (W W^T)^-1 W of the free cables; whether that is possible."""
    n, W, L, Y = space.wrench.shape[0], space.W, space.gram, space.Y
    for j in range(n):
        for k in range(j + 1):
            s = 0.0
            for i in range(count):
                s += W[j, space.free[i]] * W[k, space.free[i]]
            L[j, k] = s
    if not cholesky.factorise(L, 0.0):
        return False
    for i in range(count):
        for j in range(n):
            space.c[j] = W[j, space.free[i]]
        cholesky.solve(L, space.c, space.p[:n])
        for j in range(n):
            Y[j, i] = space.p[j]
    return True


@kernel
def weigh(weights: Array, rows: NDArray[np.int64], W6: Array, six: Array, W: Array, wrench: Array) -> None:
    """Write W (n, m) and wrench (n,) of those in six directions, moments divided by the length; of lanes, too."""
    for j in range(rows.shape[0]):
        wrench[j] = weights[j] * six[rows[j]]
        for i in range(W.shape[1]):
            W[j, i] = weights[j] * W6[rows[j], i]


@kernel
def needed(asked: Asked, q: kernels.Quaternion, six: Array, required: Array) -> None:
    """Write the vectors (k, n) of the required set in an attitude, moments divided by the length; of lanes, too."""
    rows, weights, still = asked.rows, asked.weights, (0.0, 0.0, 0.0)
    for k in range(asked.vectors.shape[0]):
        v = asked.vectors[k]
        for j in range(6):
            six[j] = v[j]
        if asked.accelerations:
            kernels.inverse_dynamics(
                asked.inertial, asked.nothing, q, still, kernels.vector(v, 0), kernels.vector(v, 3), six
            )
        for j in range(rows.shape[0]):
            required[k, j] = weights[j] * six[rows[j]]


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
    weigh(weights, rows, W6, six, space.W, space.wrench)
    for j in range(n):
        space.best[j] = math.nan
        # Of 1 kg where the platform's own mass is.
        space.load[j] = space.wrench[j] / asked.inertial[0]
    needed(asked, q, six, space.required)
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
    if r == TWO and n > 3 and count == m and asked.mode != PAYLOAD:
        pair = space.pair
        if asked.mode == CLOSURE:
            value[0], value[1] = closure_of_two(space.N), 1.0
        elif not margin_of_two(asked.form, space.W, asked.limits, space.box, space.N, space.required, pair, value):
            return SINGULAR
        else:
            for j in range(n):
                space.best[j] = pair.best[j]
        return REGULAR
    if asked.mode != CLOSURE and r < n - 1 and not invert(count, space):
        return SINGULAR
    value[0], value[1] = facets(asked.mode, asked.form, low, high, count, r, space)
    return REGULAR


def space_for(asked: Asked) -> Space:
    """Return work space for one thread."""
    n, m, k = len(asked.rows), len(asked.lines), len(asked.vectors)
    size = m + n + 1
    return Space(
        np.empty((n, m)),
        np.empty(n),
        np.empty(n),
        np.empty((k, n)),
        np.empty((3, m)),
        np.empty((m, m)),
        np.empty((n, m)),
        np.empty((n, n)),
        np.empty(m, np.int64),
        np.empty(size, np.int64),
        np.empty((size, size)),
        Pair(*(np.empty(shape) for shape in pair_shapes(n, m, k))),
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
