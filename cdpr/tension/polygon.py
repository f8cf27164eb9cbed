"""The admissible distributions of a robot with one or two cables too many: an interval, a convex polygon.

With t = c + N x, N (m, r) as from `reduce`, they are { x : low <= c + N x <= high }: for r = 1 an interval, for r = 2 a
polygon (Mikelsons, Bruckmann, Schramm and Hiller, ICRA 2008; Gouttefarde, Lamaury, Reichert and Bruckmann, IEEE Trans.
Robotics 31, 2015). Both coordinates are in newtons. The kernels allocate nothing. Limits must be finite.
"""

from __future__ import annotations

import math

from cdpr.model.jit import apart, kernel
from cdpr.model.robot import Array

# A limit counts as kept within this share of the largest tension or limit: some hundred times the round-off of
# clipping, so that a set without inner points (a segment, a point) is not lost.
TOLERANCE = 1e-12


@kernel
def most_vertices(m: int) -> int:
    """Rows that `clip_polygon` needs for its vertices: one for each limit, and four to start from."""
    return 2 * m + 4


@apart
@kernel
def clip_interval(N: Array, c: Array, low: Array, high: Array, ends: Array) -> int:
    """Write the ends of { x : low <= c + N[:, 0] x <= high } into ends[0] <= ends[1].

    Returns how many there are: 0 where the set is empty, 1 where it is a point (then written twice), 2.
    """
    tolerance = TOLERANCE * _scale(c, low, high)
    ends[0], ends[1] = -math.inf, math.inf
    lower, upper = 1.0, 1.0  # |N| of the cables that set the ends
    for i in range(c.shape[0]):
        g = N[i, 0]
        if g == 0.0:  # x does not change this cable
            if not (low[i] - tolerance <= c[i] <= high[i] + tolerance):
                return 0
            continue
        a, b = (low[i] - c[i]) / g, (high[i] - c[i]) / g
        if g < 0.0:
            a, b = b, a
        if a > ends[0]:
            ends[0], lower = a, abs(g)
        if b < ends[1]:
            ends[1], upper = b, abs(g)
    if not math.isfinite(ends[1] - ends[0]):  # x changes no cable, or the input is not finite
        return 0
    if ends[1] - ends[0] > tolerance:
        return 2
    # Half way between two limits, weighed so that both are broken, if at all, by the same number of newtons.
    share = upper / (lower + upper)
    overlap = ends[0] - ends[1]
    if overlap * lower * share > tolerance:
        return 0
    ends[0] -= share * overlap
    ends[1] = ends[0]
    return 1


@apart
@kernel
def clip_polygon(N: Array, c: Array, low: Array, high: Array, vertices: Array, work: Array) -> int:
    """Write the corners of { x : low <= c + N[:, :2] x <= high } into `vertices` (>= 2 m + 4, >= 2), anticlockwise.

    Returns how many there are: 0 where the set is empty, 1 where it is a point, 2 where it is a segment. `work` is
    as large as `vertices`.

    A square that holds them all is cut by one limit after another (Sutherland and Hodgman, Comm. ACM 17, 1974).
    """
    m = c.shape[0]
    tolerance = TOLERANCE * _scale(c, low, high)
    reach = 0.0  # |x_j| = |N_j . (t - c)| is at most this
    for j in range(2):
        s = 0.0
        for i in range(m):
            s += abs(N[i, j]) * max(abs(low[i] - c[i]), abs(high[i] - c[i]))
        reach = max(reach, s)
    reach = 2.0 * reach + 1.0  # no corner of the square remains
    old, new = vertices, work
    old[0, 0], old[0, 1], old[1, 0], old[1, 1] = -reach, -reach, reach, -reach
    old[2, 0], old[2, 1], old[3, 0], old[3, 1] = reach, reach, -reach, reach
    count = 4
    for i in range(m):
        if N[i, 0] == 0.0 and N[i, 1] == 0.0:
            if not (low[i] - tolerance <= c[i] <= high[i] + tolerance):
                return 0
            continue
        for upper in range(2):
            if upper == 1:
                count = _cut(old, count, N[i, 0], N[i, 1], high[i] - c[i], tolerance, new)
            else:
                count = _cut(old, count, -N[i, 0], -N[i, 1], c[i] - low[i], tolerance, new)
            if count == 0:
                return 0
            old, new = new, old
    return _tidy(old, count, tolerance, vertices)


@kernel
def centre_of_polygon(vertices: Array, count: int, x: Array) -> None:
    """Write the centroid of a convex polygon of `count` >= 1 corners, of a segment or of a point into x (2,).

    The mean of the triangles of a fan, weighed by their areas: never outside, however thin the polygon.
    """
    total = 0.0
    x[0] = x[1] = 0.0
    ox, oy = vertices[0, 0], vertices[0, 1]
    for k in range(2, count):
        ax, ay = vertices[k - 1, 0] - ox, vertices[k - 1, 1] - oy
        bx, by = vertices[k, 0] - ox, vertices[k, 1] - oy
        area = max(ax * by - ay * bx, 0.0)  # below zero it is round-off
        total += area
        x[0] += area * (ax + bx) / 3.0
        x[1] += area * (ay + by) / 3.0
    if total > 0.0:
        x[0] = ox + x[0] / total
        x[1] = oy + x[1] / total
    else:
        for k in range(count):
            x[0] += vertices[k, 0] / count
            x[1] += vertices[k, 1] / count


@kernel
def _scale(c: Array, low: Array, high: Array) -> float:
    largest = 0.0
    for i in range(c.shape[0]):
        largest = max(largest, abs(c[i]), abs(low[i]), abs(high[i]))
    return largest


@kernel
def _cut(old: Array, count: int, gx: float, gy: float, b: float, tolerance: float, new: Array) -> int:
    """Write what of the polygon `old` lies in g . x <= b into `new`; return its number of corners."""
    kept = 0
    px, py = old[count - 1, 0], old[count - 1, 1]
    before = gx * px + gy * py - b
    for k in range(count):
        qx, qy = old[k, 0], old[k, 1]
        now = gx * qx + gy * qy - b
        if (before <= tolerance) != (now <= tolerance) and kept < new.shape[0]:
            share = min(max(before / (before - now), 0.0), 1.0)
            new[kept, 0], new[kept, 1] = px + share * (qx - px), py + share * (qy - py)
            kept += 1
        if now <= tolerance and kept < new.shape[0]:  # a convex polygon never needs more room; round-off might ask
            new[kept, 0], new[kept, 1] = qx, qy
            kept += 1
        px, py, before = qx, qy, now
    return kept


@kernel
def _tidy(old: Array, count: int, tolerance: float, vertices: Array) -> int:
    """Copy the corners without those that coincide; of a polygon without breadth only its two ends."""
    kept = 0
    for k in range(count):
        x, y = old[k, 0], old[k, 1]
        if kept == 0 or max(abs(x - vertices[kept - 1, 0]), abs(y - vertices[kept - 1, 1])) > tolerance:
            vertices[kept, 0], vertices[kept, 1] = x, y
            kept += 1
    while kept > 1:
        last = max(abs(vertices[kept - 1, 0] - vertices[0, 0]), abs(vertices[kept - 1, 1] - vertices[0, 1]))
        if last > tolerance:
            break
        kept -= 1
    area, around = 0.0, 0.0
    for k in range(kept):
        n = (k + 1) % kept
        ax, ay = vertices[k, 0] - vertices[0, 0], vertices[k, 1] - vertices[0, 1]
        bx, by = vertices[n, 0] - vertices[0, 0], vertices[n, 1] - vertices[0, 1]
        area += ax * by - ay * bx
        around += math.hypot(bx - ax, by - ay)
    if kept <= 2 or area > tolerance * around:
        return kept
    first, second, longest = 0, 1, -1.0
    for j in range(kept):
        for k in range(j):
            distance = math.hypot(vertices[j, 0] - vertices[k, 0], vertices[j, 1] - vertices[k, 1])
            if distance > longest:
                first, second, longest = k, j, distance
    x, y = vertices[second, 0], vertices[second, 1]
    vertices[0, 0], vertices[0, 1] = vertices[first, 0], vertices[first, 1]
    vertices[1, 0], vertices[1, 1] = x, y
    return 2
