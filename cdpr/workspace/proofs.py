"""Whether the cables hold wrenches at each position of a box, or at none: proved; compiled.

With W(d), the wrench matrix where the platform is d away from the middle of the box, enclosed by `enclosure`:

- Inside: the tensions t(d) = t0 + T d, T = -Y dW t0, err in W(d) t(d) = w by a rest that is of second order. With
  W(d) Y = 1 + E(d), |E| < 1, there is a y with W(d) (t(d) + Y y) = w, no larger than that rest / (1 - |E|). So a wrench
  is held wherever t0, |T d| and |Y y| together stay within the limits.
- Outside: c(d) . w > sum max(c(d) . W_i(d) t_i) of the limits of each t_i (Farkas). c0 is normal to a facet, of which
  c(d) = c0 + G d keeps the cables at rest to first order: with a c that is constant each of them would add its largest
  tension times what W_i turns.

The idea is that of Gouttefarde, Daney and Merlet (IEEE T-RO 27(1), 2011), who solve interval linear systems instead.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.model import cholesky, kernels
from cdpr.model.jit import apart, kernel, threaded_kernel
from cdpr.model.kinds import CUBE, INDICES, NOTHING, ROW, TABLE, Group
from cdpr.model.robot import Array
from cdpr.workspace.assess import ASKED, REGULAR, SPACE, Asked, Space, look
from cdpr.workspace.enclosure import ROUNDED, ZERO, Model, inverse_distance, largest, plus, scaled, spread, times

# What is proved of a box.
OUTSIDE, UNDECIDED, INSIDE = -1, 0, 1

# W(d) Y may be so far from 1: with more the rest grows beyond use.
FAR = 0.5
# Tensions are looked for anew once it is known how they change within the box.
ROUNDS = 2
# Share of its limits that a cable keeps from them at least, where its tension does not change.
LEAST = 1e-9
# Steps of the barrier, by how much its weight grows in each, how close to the best it then is, in multiples of what
# tensions change by, and from how many of these on there is no need of more.
STEPS, FASTER, CLOSE, ENOUGH = 24, 2.5, 0.05, 2.0
# Share of the largest diagonal by which systems that may be singular are damped: what they give is proved afterwards.
DAMPING = 1e-12


class Boxes(NamedTuple):
    """What is looked at."""

    poses: Array  # (K, 7), of the middles
    halves: Array  # (K, 3), half sides, m
    wrenches: Array  # (k, n), all of which must be held; moments divided by the characteristic length
    errors: Array  # (2,), of lengths, m, and of the wrenches: what rounding has made of what is given
    proved: NDArray[np.int64]  # (K,)


BOXES = Group((TABLE, TABLE, TABLE, ROW, INDICES), Boxes)


class Room(NamedTuple):
    """Work space for n directions and m cables."""

    columns: Array  # (m, n, 5), models of the columns of W
    parts: Array  # (6, 5)
    Y: Array  # (m, n), about W^+
    gram: Array  # (n, n)
    small: Array  # (m + 1, m + 1)
    t: Array  # (m,)
    base: Array  # (m,)
    T: Array  # (m, 3), changes of t from the middle of the box to its sides
    G: Array  # (n, 3), of c likewise
    a: Array  # (m + n,)
    b: Array
    step: Array
    need: Array  # (m,)
    chosen: NDArray[np.int64]  # (m,)


ROOM = Group((CUBE, TABLE, TABLE, TABLE, TABLE, ROW, ROW, TABLE, TABLE, ROW, ROW, ROW, ROW, INDICES), Room)


@kernel
def get(table: Array, row: int) -> Model:
    """Return the model in a row."""
    return table[row, 0], table[row, 1], table[row, 2], table[row, 3], table[row, 4]


@kernel
def put(table: Array, row: int, a: Model) -> None:
    """Write a model into a row."""
    for i in range(5):
        table[row, i] = a[i]


@apart
@kernel
def enclose(asked: Asked, pose: Array, half: Array, error: float, room: Room) -> bool:
    """Write models of the columns of W; whether no anchor on the frame may lie on the platform's."""
    p, q = kernels.vector(pose, 0), kernels.quaternion(pose, 3)
    h = kernels.vector(half, 0)
    for i in range(asked.lines.shape[0]):
        b = kernels.rotate(q, kernels.vector(asked.lines[i], 3))
        v = (
            asked.lines[i, 0] - p[0] - b[0],
            asked.lines[i, 1] - p[1] - b[1],
            asked.lines[i, 2] - p[2] - b[2],
        )
        s = inverse_distance(v, h, error)
        if not s[4] < math.inf:
            return False
        put(room.parts, 0, times((v[0], -h[0], 0.0, 0.0, error), s))
        put(room.parts, 1, times((v[1], 0.0, -h[1], 0.0, error), s))
        put(room.parts, 2, times((v[2], 0.0, 0.0, -h[2], error), s))
        for k in range(3):
            j, o = (k + 1) % 3, (k + 2) % 3
            first = times((b[j], 0.0, 0.0, 0.0, error), get(room.parts, o))
            put(room.parts, 3 + k, plus(first, times((-b[o], 0.0, 0.0, 0.0, error), get(room.parts, j))))
        for j in range(asked.rows.shape[0]):
            put(room.columns[i], j, scaled(get(room.parts, asked.rows[j]), asked.weights[j]))
    return True


@kernel
def invert(count: int, space: Space, room: Room) -> bool:
    """Write Y = W^T (W W^T)^-1 of the cables that are free, zeros for the others; whether that is possible."""
    n, m, W, L = space.W.shape[0], room.t.shape[0], space.W, room.gram
    for j in range(n):
        for k in range(j + 1):
            s = 0.0
            for i in range(count):
                s += W[j, space.free[i]] * W[k, space.free[i]]
            L[j, k] = s
    if not cholesky.factorise(L, 0.0):
        return False
    for i in range(m):
        for j in range(n):
            room.Y[i, j] = 0.0
    for i in range(count):
        f = space.free[i]
        for j in range(n):
            room.a[j] = W[j, f]
        cholesky.solve(L, room.a[:n], room.Y[f])
    return True


@kernel
def near_one(n: int, room: Room) -> float:
    """Return what |W(d) Y - 1| is at most: of its rows, the largest sum of sizes."""
    worst = 0.0
    for j in range(n):
        total = 0.0
        for k in range(n):
            e = (-1.0 if j == k else 0.0, 0.0, 0.0, 0.0, 0.0)
            for i in range(room.t.shape[0]):
                e = plus(e, scaled(get(room.columns[i], j), room.Y[i, k]))
            total += largest(e)
        worst = max(worst, total * (1.0 + ROUNDED))
        if not total < math.inf:
            return math.inf
    return worst


@kernel
def centre(r: int, low: Array, high: Array, space: Space, room: Room) -> None:
    """Write t = base + N y that is as far from the limits as it can be, in shares of what it changes by in the box.

    The largest s with |t_i - limit| >= s |T_i| of all cables, by a barrier: damped steps of Newton stay within the
    constraints of a self-concordant one by themselves (Nesterov and Nemirovskii 1994). Any t is as good for a proof.
    """
    m, N, L, step, t, need = low.shape[0], space.N, room.small, room.step, room.t, room.need
    s = math.inf
    for i in range(m):
        t[i] = room.base[i]
        need[i] = abs(room.T[i, 0]) + abs(room.T[i, 1]) + abs(room.T[i, 2]) + LEAST * (high[i] - low[i])
        if low[i] < high[i]:
            s = min(s, min(t[i] - low[i], high[i] - t[i]) / need[i])
    s -= 1.0
    weight = 2.0 * m / (1.0 + abs(s))
    for _ in range(STEPS):
        for j in range(r + 1):
            step[j] = weight if j == r else 0.0
            for k in range(j + 1):
                L[j, k] = 0.0
        for i in range(m):
            if not low[i] < high[i]:
                continue
            below, above = 1.0 / (t[i] - low[i] - s * need[i]), 1.0 / (high[i] - t[i] - s * need[i])
            pull, push = below - above, below + above
            curve, cross = below * below + above * above, pull * push
            for j in range(r):
                step[j] += pull * N[i, j]
                for k in range(j + 1):
                    L[j, k] += curve * N[i, j] * N[i, k]
                L[r, j] -= cross * need[i] * N[i, j]
            step[r] -= push * need[i]
            L[r, r] += curve * need[i] * need[i]
        if not cholesky.factorise(L[: r + 1], 0.0):
            return
        cholesky.solve(L, step[: r + 1], room.a[: r + 1])
        decrement = 0.0
        for j in range(r + 1):
            decrement += step[j] * room.a[j]
        share = 1.0 / (1.0 + math.sqrt(max(decrement, 0.0)))
        s += share * room.a[r]
        for i in range(m):
            for j in range(r):
                t[i] += share * N[i, j] * room.a[j]
        if s > ENOUGH:
            return
        weight = min(FASTER * weight, 2.0 * m / CLOSE)


@kernel
def rates(n: int, room: Room) -> None:
    """Write T = -Y dW t."""
    m = room.t.shape[0]
    for k in range(3):
        for j in range(n):
            room.a[j] = 0.0
            for i in range(m):
                room.a[j] += room.columns[i, j, 1 + k] * room.t[i]
        for i in range(m):
            room.T[i, k] = 0.0
            for j in range(n):
                room.T[i, k] -= room.Y[i, j] * room.a[j]


@kernel
def held(wrench: Array, error: float, far: float, low: Array, high: Array, room: Room) -> bool:
    """Whether t + T d, with what is left balanced by Y y, is within the limits at all d."""
    n, m, rest = wrench.shape[0], low.shape[0], 0.0
    for j in range(n):
        s = (-wrench[j], 0.0, 0.0, 0.0, error)
        for i in range(m):
            s = plus(s, times(get(room.columns[i], j), (room.t[i], room.T[i, 0], room.T[i, 1], room.T[i, 2], 0.0)))
        rest = max(rest, largest(s))
        if not rest < math.inf:
            return False
    rest /= 1.0 - far
    for i in range(m):
        moved = 0.0
        for j in range(n):
            moved += abs(room.Y[i, j])
        moved = moved * rest + abs(room.T[i, 0]) + abs(room.T[i, 1]) + abs(room.T[i, 2])
        moved = moved * (1.0 + 16.0 * ROUNDED) + ROUNDED * (abs(room.t[i]) + abs(low[i]) + abs(high[i]))
        if low[i] == high[i]:
            if not (room.t[i] == low[i] and moved <= 2.0 * ROUNDED * (abs(room.t[i]) + abs(low[i]) + abs(high[i]))):
                return False
        elif not (room.t[i] - low[i] >= moved and high[i] - room.t[i] >= moved):
            return False
    return True


@apart
@kernel
def inside(boxes: Boxes, r: int, count: int, low: Array, high: Array, space: Space, room: Room) -> bool:
    """Whether all wrenches are held everywhere in the box."""
    n, m = space.W.shape[0], low.shape[0]
    if not invert(count, space, room):
        return False
    far = near_one(n, room)
    if not far < FAR:
        return False
    for w in range(boxes.wrenches.shape[0]):
        wrench = boxes.wrenches[w]
        for i in range(m):
            room.base[i] = space.box[0, i]
            for j in range(n):
                room.base[i] += room.Y[i, j] * (wrench[j] - space.wrench[j])
        for i in range(m):
            room.t[i] = room.base[i]
        rates(n, room)
        for _ in range(ROUNDS if r > 0 else 0):
            centre(r, low, high, space, room)
            rates(n, room)
        if not held(wrench, boxes.errors[1], far, low, high, room):
            return False
    return True


@kernel
def follow(count: int, space: Space, room: Room) -> None:
    """Write G with which c(d) . W_i(d) stays to first order what it is, of the n - 1 cables where it is least."""
    n, W, c, L = space.W.shape[0], space.W, space.best, room.gram
    for i in range(count):
        s, f = 0.0, space.free[i]
        for j in range(n):
            s += c[j] * W[j, f]
        room.a[i], room.chosen[i] = abs(s), f
    several = min(n - 1, count)
    for k in range(several):
        least = k
        for i in range(k + 1, count):
            if room.a[i] < room.a[least]:
                least = i
        room.a[k], room.a[least] = room.a[least], room.a[k]
        room.chosen[k], room.chosen[least] = room.chosen[least], room.chosen[k]
    size = 1.0
    for j in range(n):
        for k in range(j + 1):
            s = c[j] * c[k]
            for i in range(several):
                s += W[j, room.chosen[i]] * W[k, room.chosen[i]]
            L[j, k] = s
        size = max(size, L[j, j])
    for j in range(n):
        L[j, j] += DAMPING * size
    sound = cholesky.factorise(L, 0.0)
    for k in range(3):
        for j in range(n):
            room.b[j] = 0.0
        for i in range(several):
            s = 0.0
            for j in range(n):
                s += c[j] * room.columns[room.chosen[i], j, 1 + k]
            for j in range(n):
                room.b[j] -= s * W[j, room.chosen[i]]
        if sound:
            cholesky.solve(L, room.b[:n], room.a[:n])
        for j in range(n):
            room.G[j, k] = room.a[j] if sound else 0.0


@apart
@kernel
def outside(boxes: Boxes, count: int, low: Array, high: Array, space: Space, room: Room) -> bool:
    """Whether one of the wrenches is beyond a facet everywhere in the box."""
    n, m, c = space.W.shape[0], low.shape[0], space.best
    follow(count, space, room)
    worst, farthest = 0, -math.inf
    for w in range(boxes.wrenches.shape[0]):
        reached = 0.0
        for j in range(n):
            reached += c[j] * boxes.wrenches[w, j]
        if reached > farthest:
            worst, farthest = w, reached
    total, rest = ZERO, 0.0
    for j in range(n):
        along = (c[j], room.G[j, 0], room.G[j, 1], room.G[j, 2], 0.0)
        total = plus(total, times(along, (-boxes.wrenches[worst, j], 0.0, 0.0, 0.0, boxes.errors[1])))
    for i in range(m):
        s = ZERO
        for j in range(n):
            along = (c[j], room.G[j, 0], room.G[j, 1], room.G[j, 2], 0.0)
            s = plus(s, times(along, get(room.columns[i], j)))
        if abs(s[0]) > (spread(s) + s[4]) * (1.0 + ROUNDED):
            total = plus(total, scaled(s, high[i] if s[0] > 0.0 else low[i]))
        else:
            middle = 0.5 * (low[i] + high[i])
            total = plus(total, scaled(s, middle))
            rest += max(high[i] - middle, middle - low[i]) * (1.0 + ROUNDED) * largest(s)
    return total[0] + (spread(total) + total[4] + rest) * (1.0 + 16.0 * ROUNDED) < -ROUNDED * abs(total[0])


def room_for(n: int, m: int) -> Room:
    """Return work space for one thread."""
    several = n + m
    return Room(
        np.empty((m, n, 5)),
        np.empty((6, 5)),
        np.empty((m, n)),
        np.empty((n, n)),
        np.empty((m + 1, m + 1)),
        np.empty(m),
        np.empty(m),
        np.empty((m, 3)),
        np.empty((n, 3)),
        np.empty(several),
        np.empty(several),
        np.empty(several),
        np.empty(m),
        np.empty(m, np.int64),
    )


@threaded_kernel(NOTHING(ASKED, BOXES, SPACE, ROOM))
def prove(asked: Asked, boxes: Boxes, space: Space, room: Room) -> None:
    """Write what is proved of all boxes."""
    n, m = asked.rows.shape[0], asked.lines.shape[0]
    low, high = asked.limits[0], asked.limits[1]
    for b in range(boxes.poses.shape[0]):
        boxes.proved[b] = UNDECIDED
        if look(asked, boxes.poses[b], space) != REGULAR:
            continue
        if not enclose(asked, boxes.poses[b], boxes.halves[b], boxes.errors[0], room):
            continue
        count = 0
        for i in range(m):
            if low[i] < high[i]:
                count += 1
        if space.value[0] < 0.0:
            if outside(boxes, count, low, high, space, room):
                boxes.proved[b] = OUTSIDE
        elif inside(boxes, count - n, count, low, high, space, room):
            boxes.proved[b] = INSIDE
