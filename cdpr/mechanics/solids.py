"""Distances from convex solids and between segments: compiled.

A solid is a row (11,): its kind, the middle (3,), its attitude (4,) and its size (3,): half widths of a box; radius of
a sphere; radius and half height of a cylinder. That of a convex hull is longer: its size is the numbers of its
triangles and edges and the radius of a sphere around it; then come of each triangle its normal (3,), height and corners
(9,), and of each edge both ends (6,), from the middle. Of a hull `from_solid` alone is there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.hull import convex_hull
from cdpr.model.jit import kernel, small
from cdpr.model.kernels import Vector, conjugate, cross, dot, quaternion, rotate, vector
from cdpr.model.lanes import choose, every
from cdpr.model.robot import Array
from cdpr.model.shapes import Box, Cylinder, Hull, Mesh, Shape, Sphere

WIDTH = 11
BOX, SPHERE, CYLINDER, HULL = range(4)
FACE, EDGE = 13, 6  # numbers of a triangle and of an edge of a hull
UPRIGHT = (1.0, 0.0, 0.0, 0.0)

# Halvings of a segment on the way to where it is nearest to a solid: to the last digit of its length.
HALVINGS = 52

# Square of the sine of an angle, below which the round-off of where two lines are nearest is felt.
PARALLEL = 1e-6


def row(shape: Shape | Hull, position: ArrayLike = (0.0, 0.0, 0.0), attitude: Sequence[float] = UPRIGHT) -> Array:
    """Return a shape in this place, m, as kernels take it; of a mesh the box around it."""
    middle, kind, size, more = np.zeros(3), BOX, (0.0, 0.0, 0.0), np.zeros(0)
    if isinstance(shape, Box):
        x, y, z = shape.size
        size = (0.5 * x, 0.5 * y, 0.5 * z)
    elif isinstance(shape, Sphere):
        kind, size = SPHERE, (shape.radius, 0.0, 0.0)
    elif isinstance(shape, Cylinder):
        kind, size = CYLINDER, (shape.radius, 0.5 * shape.height, 0.0)
    elif isinstance(shape, Mesh):
        low, high = np.array(shape.lower), np.array(shape.upper)
        x, y, z = (0.5 * (high - low)).tolist()
        middle, size = 0.5 * (low + high), (x, y, z)
    elif isinstance(shape, Hull):
        kind, (middle, size, more) = HULL, _hull(np.array(shape.corners))
    w, x, y, z = attitude
    turned = np.array(rotate((w, x, y, z), (middle[0], middle[1], middle[2])))
    return np.concatenate([[kind], np.asarray(position) + turned, attitude, size, more])


def rows(solids: Sequence[Array]) -> Array:
    """Return the rows of several, (k, 11 or more), filled up with zeros."""
    table = np.zeros((len(solids), max(map(len, solids), default=WIDTH)))
    for line, solid in zip(table, solids, strict=True):
        line[: len(solid)] = solid
    return table


def _hull(points: Array) -> tuple[Array, tuple[float, float, float], Array]:
    """Middle (3,), size and the other numbers of a hull of points (k, 3)."""
    corners, triangles = convex_hull(points)
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    corners = corners - middle
    a, b, c = (corners[triangles[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    heights = np.max(corners @ normals.T, axis=0)  # of a face that is rough by round-off: above all corners
    edges = np.array([(i, j) for t in triangles.tolist() for i, j in zip(t, (t[1], t[2], t[0]), strict=True) if i < j])
    radius = float(np.linalg.norm(corners, axis=1).max())
    faces = np.column_stack([normals, heights, a, b, c])
    return middle, (len(faces), len(edges), radius), np.concatenate([faces.ravel(), corners[edges].ravel()])


@small
@kernel
def into(solid: Array, x: Vector) -> Vector:
    """Return a point, m, in the axes of a solid, from its middle."""
    return rotate(conjugate(quaternion(solid, 4)), (x[0] - solid[1], x[1] - solid[2], x[2] - solid[3]))


@small
@kernel
def signed_distance(solid: Array, x: Vector) -> tuple[float, Vector]:
    """Return how far a point in its axes is outside of a solid, m, negative inside, and where that grows, of length 1.

    As the solid is convex, so is this function.
    """
    a, b, c = solid[8], solid[9], solid[10]
    if solid[0] == SPHERE:
        size = math.sqrt(dot(x, x))
        return size - a, ((x[0] / size, x[1] / size, x[2] / size) if size > 0.0 else (1.0, 0.0, 0.0))
    if solid[0] == CYLINDER:
        r = math.hypot(x[0], x[1])
        across, up = (x[0] / r if r > 0.0 else 1.0), math.copysign(1.0, x[2])
        away = x[1] / r if r > 0.0 else 0.0
        p, q = r - a, abs(x[2]) - b
        if p > 0.0 and q > 0.0:
            size = math.hypot(p, q)
            return size, (across * p / size, away * p / size, up * q / size)
        if p > q:
            return p, (across, away, 0.0)
        return q, (0.0, 0.0, up)
    p, q, s = abs(x[0]) - a, abs(x[1]) - b, abs(x[2]) - c
    if p <= 0.0 and q <= 0.0 and s <= 0.0:
        if p >= q and p >= s:
            return p, (math.copysign(1.0, x[0]), 0.0, 0.0)
        if q >= s:
            return q, (0.0, math.copysign(1.0, x[1]), 0.0)
        return s, (0.0, 0.0, math.copysign(1.0, x[2]))
    u, v, w = max(p, 0.0), max(q, 0.0), max(s, 0.0)
    size = math.sqrt(u * u + v * v + w * w)
    return size, (
        math.copysign(u / size, x[0]),
        math.copysign(v / size, x[1]),
        math.copysign(w / size, x[2]),
    )


@kernel
def highest(hull: Array, a: Vector, d: Vector, s: float) -> tuple[float, float, float]:
    """Return how high a + s d is above the face above which it is highest; and at s = 0, and its slope over s."""
    value, first, slope = -math.inf, 0.0, 0.0
    for k in range(int(hull[8])):
        at = WIDTH + FACE * k
        n = vector(hull, at)
        low, up = dot(n, a) - hull[at + 3], dot(n, d)
        if low + s * up > value:
            value, first, slope = low + s * up, low, up
    return value, first, slope


@kernel
def lowest(hull: Array, a: Vector, d: Vector) -> float:
    """Return the least of that height for s from 0 to 1, where it is negative; else something that is not.

    It is the largest of straight lines, one for each face: where those meet that are the largest on either side, it is
    least, unless another one is above them there, which takes the place of one.
    """
    value, low, down = highest(hull, a, d, 0.0)
    if down >= 0.0:
        return value
    value, high, up = highest(hull, a, d, 1.0)
    if up <= 0.0:
        return value
    for _ in range(int(hull[8])):
        s = min(max((high - low) / (down - up), 0.0), 1.0)
        if low + s * down > 0.0:
            return low + s * down
        value, first, slope = highest(hull, a, d, s)
        if slope == 0.0 or (first == low and slope == down) or (first == high and slope == up):
            break
        if slope < 0.0:
            low, down = first, slope
        else:
            high, up = first, slope
    return value


@kernel
def from_hull(hull: Array, a: Vector, b: Vector) -> float:
    """Return the distance of a segment, in its axes, from a convex hull, m; negative as that of other solids.

    Where they do not meet, it is that from an edge, or that of an end from a face that it is above.
    """
    least = lowest(hull, a, (b[0] - a[0], b[1] - a[1], b[2] - a[2]))
    if least < 0.0:
        return least
    least, faces = math.inf, int(hull[8])
    for k in range(faces):
        at = WIDTH + FACE * k
        n = vector(hull, at)
        for x in (a, b):
            height = dot(n, x) - hull[at + 3]
            if 0.0 <= height < least and over(hull, at + 4, n, x):
                least = height
    for k in range(int(hull[9])):
        at = WIDTH + FACE * faces + EDGE * k
        least = min(least, between(a, b, vector(hull, at), vector(hull, at + 3)))
    return least


@kernel
def over(hull: Array, at: int, n: Vector, x: Vector) -> bool:
    """Whether a point is over, or under, a triangle whose corners stand at `at`; not over its edges."""
    for k in range(3):
        p, q = vector(hull, at + 3 * k), vector(hull, at + 3 * ((k + 1) % 3))
        side = cross((q[0] - p[0], q[1] - p[1], q[2] - p[2]), (x[0] - p[0], x[1] - p[1], x[2] - p[2]))
        if dot(side, n) <= 0.0:
            return False
    return True


@kernel
def beyond(solid: Array, start: Vector, end: Vector) -> float:
    """Return the distance of a segment from a sphere around a solid, m: soon told, and no larger than its own."""
    a, b, c = solid[8], solid[9], solid[10]
    radius = math.sqrt(a * a + b * b + c * c)
    if solid[0] == HULL:
        radius = c
    elif solid[0] == CYLINDER:
        radius = math.hypot(a, b)
    return float(from_point(vector(solid, 1), start, end) - radius)


@kernel
def from_solid(solid: Array, start: Vector, end: Vector) -> float:
    """Return the least of those distances along a segment, whose ends are in the world, m; convex, so by halving."""
    a, b = into(solid, start), into(solid, end)
    if solid[0] == HULL:
        return from_hull(solid, a, b)
    d = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    first, ahead = signed_distance(solid, a)
    if dot(ahead, d) >= 0.0:
        return first
    last, ahead = signed_distance(solid, b)
    if dot(ahead, d) <= 0.0:
        return last
    low, high, least = 0.0, 1.0, min(first, last)
    for _ in range(HALVINGS):
        s = 0.5 * (low + high)
        value, ahead = signed_distance(solid, (a[0] + s * d[0], a[1] + s * d[1], a[2] + s * d[2]))
        least = min(least, value)
        if dot(ahead, d) < 0.0:
            low = s
        else:
            high = s
    return least


@kernel
def above(solid: Array, anchor: Vector, end: Vector, near: float) -> float:
    """Return how high the end of a cable is above a solid's faces on which its anchor is, both in its axes, m.

    A cable from a point of the surface passes through the solid where this is negative (its tangent cone there), and
    only there. NaN where the anchor is farther than `near` from all faces, or nowhere near the surface.
    """
    a, b, c = solid[8], solid[9], solid[10]
    height = math.nan
    if solid[0] == SPHERE:
        size = math.sqrt(dot(anchor, anchor))
        if abs(size - a) <= near:
            height = dot(anchor, end) / size - size
    elif solid[0] == CYLINDER:
        r = math.hypot(anchor[0], anchor[1])
        if abs(r - a) <= near:
            height = (anchor[0] * end[0] + anchor[1] * end[1]) / r - r
        if abs(abs(anchor[2]) - b) <= near:
            up = math.copysign(end[2], anchor[2] * end[2]) - abs(anchor[2])
            height = up if math.isnan(height) else max(height, up)
    else:
        for k in range(3):
            half = a if k == 0 else (b if k == 1 else c)
            if abs(abs(anchor[k]) - half) <= near:
                up = math.copysign(end[k], anchor[k] * end[k]) - abs(anchor[k])
                height = up if math.isnan(height) else max(height, up)
    return height


@kernel
def from_point(x: Vector, start: Vector, end: Vector) -> float:
    """Return the distance of a point from a segment, m; of lanes, too."""
    return math.sqrt(_square(x, start, end))


@kernel
def _square(x: Vector, start: Vector, end: Vector) -> float:
    """The square of that distance."""
    d = (end[0] - start[0], end[1] - start[1], end[2] - start[2])
    r = (x[0] - start[0], x[1] - start[1], x[2] - start[2])
    square, along = dot(d, d), dot(r, d)
    # As plain Python, which an uncompiled kernel is, the division would raise where it does not count.
    s = choose(along <= 0.0, 0.0, choose(along >= square, 1.0, along / choose(square > 0.0, square, 1.0)))
    away = (r[0] - s * d[0], r[1] - s * d[1], r[2] - s * d[2])
    return dot(away, away)


@kernel
def between(start: Vector, end: Vector, first: Vector, last: Vector) -> float:
    """Return the distance between two segments, m: of where their lines are nearest, or from an end; of lanes, too."""
    d = (end[0] - start[0], end[1] - start[1], end[2] - start[2])
    e = (last[0] - first[0], last[1] - first[1], last[2] - first[2])
    r = (start[0] - first[0], start[1] - first[1], start[2] - first[2])
    dd, ee, de, dr, er = dot(d, d), dot(e, e), dot(d, e), dot(d, r), dot(e, r)
    square = dd * ee - de * de
    by = choose(square > 0.0, square, 1.0)  # of parallel segments, for plain Python: the ends decide there
    s, t = (de * er - ee * dr) / by, (dd * er - de * dr) / by
    away = (r[0] + s * d[0] - t * e[0], r[1] + s * d[1] - t * e[1], r[2] + s * d[2] - t * e[2])
    within = (square > 0.0) & (s > 0.0) & (s < 1.0) & (t > 0.0) & (t < 1.0)
    sure = within & (square > PARALLEL * dd * ee)
    found = choose(within, dot(away, away), math.inf)
    if not every(sure):
        ends = min(
            min(_square(start, first, last), _square(end, first, last)),
            min(_square(first, start, end), _square(last, start, end)),
        )
        found = choose(sure, found, min(found, ends))
    return math.sqrt(found)
