"""Cubic B-splines that follow polygons within a tolerance: where their knots are, and their polynomials; compiled.

The control points lie on the polygon, at the means of three knots each (Schoenberg's variation-diminishing spline, de
Boor 1978, chapter XI), or in curves as far outside of it as makes parabolas exact: so straight stretches stay as they
are, and wide spans average what many short chords zigzag.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.trajectory.worth import MISSES

Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Knots on both sides of vertices that are nearer to each other, or to the next vertex, than this share of its size
# become one, or none.
NEAR = 0.5

GAP = 1e-6  # m, between knots: from points so near, second derivatives are still precise to 1e-4 / m

# A vertex of a size that is no more than so many times the longer chord beside it is a knot: with fewer knots than
# vertices, but not many fewer, the curvature would go up and down.
OWN = 1.5

SLOPE = 0.1  # by which sizes change along the polygon, at most

# Places of each span, at whose ends it is held to the polygon; between two the distance exceeds both ends' by at most
# an eighth of the second derivative times their distance squared.
PLACES = 8

# Sizes shrink by one of these factors where the curve misses its polygon by more than FAR tolerances, or less.
FAR, MUCH, LITTLE = 4.0, 0.5, 0.9
ROUNDS = 60  # of them; then each vertex is rounded alone, within halves of its chords

WIDE = 0.2  # rad, by which a span of a curve may turn that is wider than chords: beyond, bounds are looser

ALONE = 0.8  # of the size at which a single corner is missed by its tolerance, so that merged knots keep it, too


@kernel
def grade(way: Array, size: Array, first: int, last: int) -> None:
    """Let sizes of vertices differ by no more than a share of their distance."""
    for k in range(first + 1, last + 1):
        size[k] = min(size[k], size[k - 1] + SLOPE * (way[k] - way[k - 1]))
    for k in range(last - 1, first - 1, -1):
        size[k] = min(size[k], size[k + 1] + SLOPE * (way[k + 1] - way[k]))


@kernel
def widen(way: Array, size: Array, first: int, last: int) -> None:
    """Let no size be less than another one's less that share of their distance."""
    for k in range(first + 1, last + 1):
        size[k] = max(size[k], size[k - 1] - SLOPE * (way[k] - way[k - 1]))
    for k in range(last - 1, first - 1, -1):
        size[k] = max(size[k], size[k + 1] - SLOPE * (way[k + 1] - way[k]))


@kernel
def fill(way: Array, size: Array, first: int, last: int, knots: Array, spans: int, end: float) -> int:
    """Append a knot at `end`, and before it as many as sizes ask for, evenly by the sizes; return how many spans."""
    begin, k = knots[spans], first
    while k < last - 1 and way[k + 1] <= begin:
        k += 1
    total, place, chord = 0.0, begin, k
    while place < end:
        after = min(way[chord + 1], end)
        total += 2.0 * (after - place) / (size[chord] + size[chord + 1])
        place = after
        chord += 1
    many = min(max(int(total + 0.5), 1), 2 * (chord - k))  # sizes are wider than most chords
    reached, place = 0.0, begin
    for i in range(1, many):
        while True:
            across = 0.5 * (size[k] + size[k + 1])
            left = (way[k + 1] - place) / across
            if reached + left >= total * i / many or k == last - 1:
                break
            reached += left
            place = way[k + 1]
            k += 1
        spans += 1
        knots[spans] = place + (total * i / many - reached) * across
    spans += 1
    knots[spans] = end
    return spans


@kernel
def knots_of(way: Array, size: Array, first: int, last: int, knots: Array) -> int:
    """Place knots between vertices `first` and `last` and return how many spans they make.

    A vertex has a knot of its own, and one on both sides as far as its size, where that is no more than a chord beside
    it. Between these, where sizes are more than chords, knots do not heed vertices, and are as far apart as sizes.
    """
    knots[0] = way[first]
    spans, filled, skipped = 0, first, False
    for k in range(first, last):
        begin, end, before, after = way[k], way[k + 1], size[k], size[k + 1]
        own = k == first or before <= OWN * max(end - begin, begin - way[k - 1])
        if own and way[last] - begin > GAP:
            if begin > knots[spans] + GAP:
                spans = fill(way, size, filled, last, knots, spans, begin) if skipped else spans + 1
                knots[spans] = begin
            filled, skipped = k, False
        skipped = skipped or not own
        owns = k + 1 == last or after <= OWN * max(end - begin, way[k + 2] - end)
        left, right = begin + before, end - after
        has_left = own and max(begin, knots[spans]) + GAP < left < end - max(NEAR * after, GAP)
        has_right = owns and begin + max(NEAR * before, GAP) < right < end - GAP
        if has_left and has_right and right - left < NEAR * min(before, after):
            left = 0.5 * (left + right)
            has_right = False
        if has_left:
            spans += 1
            knots[spans] = left
        if has_right and right > knots[spans] + GAP:
            spans = fill(way, size, filled, last, knots, spans, right) if skipped else spans + 1
            knots[spans] = right
            filled, skipped = k, False
    spans = fill(way, size, filled, last, knots, spans, way[last]) if skipped else spans + 1
    knots[spans] = way[last]
    return spans


@kernel
def knot(knots: Array, spans: int, j: int) -> float:
    """Return a knot; before the first and behind the last one they coincide."""
    return float(knots[min(max(j, 0), spans)])


@kernel
def controls_of(points: Array, way: Array, first: int, last: int, knots: Array, spans: int, controls: Array) -> None:
    """Write the control points (spans + 3, 7): where each is, its place, and where the polygon is there.

    Points of the polygon alone would make arcs smaller, by a sixth of a span squared over the radius. Where the polygon
    turns likewise before and behind them they are moved outward, as for a parabola of the least of these curvatures.
    """
    k = first
    for i in range(spans + 3):
        s = (knot(knots, spans, i - 2) + knot(knots, spans, i - 1) + knot(knots, spans, i)) / 3.0
        if i == 0:
            s = knots[0]
        if i == spans + 2:
            s = knots[spans]
        while k < last - 1 and way[k + 1] < s:
            k += 1
        share = (s - way[k]) / (way[k + 1] - way[k])
        controls[i, 3] = s
        for axis in range(3):
            controls[i, axis] = points[k, axis] + share * (points[k + 1, axis] - points[k, axis])
            controls[i, 4 + axis] = controls[i, axis]
    for i in range(1, spans + 2):
        x, y, z = curvature(controls, i)
        own = math.sqrt(x * x + y * y + z * z)
        least = own
        for other in (max(i - 1, 1), min(i + 1, spans + 1)):
            u, v, w = curvature(controls, other)
            least = min(least, math.sqrt(u * u + v * v + w * w)) if x * u + y * v + z * w > 0.0 else 0.0
        if least > 0.0:
            before, middle, after = knot(knots, spans, i - 2), knot(knots, spans, i - 1), knot(knots, spans, i)
            spread = (middle - before) ** 2 + (after - middle) ** 2 + (after - before) ** 2
            outward = least / own * spread / 36.0
            controls[i, 0] -= outward * x
            controls[i, 1] -= outward * y
            controls[i, 2] -= outward * z


@kernel
def moved(controls: Array, i: int) -> bool:
    """Say whether a control point is not on the polygon."""
    return bool(
        controls[i, 0] != controls[i, 4] or controls[i, 1] != controls[i, 5] or controls[i, 2] != controls[i, 6]
    )


@kernel
def curvature(controls: Array, i: int) -> tuple[float, float, float]:
    """Return the second derivative of a parabola through the polygon at a control point and both beside it."""
    before, after = controls[i, 3] - controls[i - 1, 3], controls[i + 1, 3] - controls[i, 3]
    x = (controls[i + 1, 4] - controls[i, 4]) / after - (controls[i, 4] - controls[i - 1, 4]) / before
    y = (controls[i + 1, 5] - controls[i, 5]) / after - (controls[i, 5] - controls[i - 1, 5]) / before
    z = (controls[i + 1, 6] - controls[i, 6]) / after - (controls[i, 6] - controls[i - 1, 6]) / before
    scale = 2.0 / (before + after)
    return scale * x, scale * y, scale * z


@kernel
def span_of(knots: Array, spans: int, controls: Array, j: int, axis: int) -> tuple[float, float, float, float]:
    """Return place, slope, and second derivatives at both ends of a span, of one coordinate (de Boor's algorithm)."""
    here, after = knots[j], knots[j + 1]
    before2, before = knot(knots, spans, j - 2), knot(knots, spans, j - 1)
    after2 = knot(knots, spans, j + 2)
    p0, p1, p2, p3 = controls[j, axis], controls[j + 1, axis], controls[j + 2, axis], controls[j + 3, axis]
    a0, a1 = (here - before2) / (after - before2), (here - before) / (after2 - before)
    a2 = (here - before) / (after - before)
    x0, x1 = p0 + a0 * (p1 - p0), p1 + a1 * (p2 - p1)
    d1 = (p1 - p0) / (controls[j + 1, 3] - controls[j, 3])
    d2 = (p2 - p1) / (controls[j + 2, 3] - controls[j + 1, 3])
    d3 = (p3 - p2) / (controls[j + 3, 3] - controls[j + 2, 3])
    return (
        x0 + a2 * (x1 - x0),
        d1 + a2 * (d2 - d1),
        2.0 * (d2 - d1) / (after - before),
        2.0 * (d3 - d2) / (after2 - here),
    )


@kernel
def write_span(knots: Array, spans: int, controls: Array, j: int, span: Array) -> None:
    """Write what `span_of` says of each coordinate into `span` (3, 4)."""
    for axis in range(3):
        c = span[axis]
        c[0], c[1], c[2], c[3] = span_of(knots, spans, controls, j, axis)


@kernel
def missed(span: Array, length: float, x: float, points: Array, share: float, k: int) -> float:
    """Return how far the curve is from the polygon's place on chord `k`, at x from the span's beginning."""
    square = 0.0
    for axis in range(3):
        c = span[axis]
        place = c[0] + x * (c[1] + x * (0.5 * c[2] + x * (c[3] - c[2]) / (6.0 * length)))
        away = place - points[k, axis] - share * (points[k + 1, axis] - points[k, axis])
        square += away * away
    return math.sqrt(square)


@kernel
def hold_to(
    points: Array,
    way: Array,
    tolerance: Array,
    first: int,
    last: int,
    knots: Array,
    spans: int,
    controls: Array,
    span: Array,
    factor: Array,
) -> bool:
    """Say whether the curve keeps the tolerance of each chord, in spans that are not too wide.

    Where not, write by what sizes are to be multiplied.
    """
    kept = True
    for k in range(first, last + 1):
        factor[k] = 1.0
    k, low, high = first, first, first
    for j in range(spans):
        length, bend, before = knots[j + 1] - knots[j], 0.0, k
        write_span(knots, spans, controls, j, span)
        for end in (2, 3):
            bend = max(bend, math.sqrt(span[0, end] ** 2 + span[1, end] ** 2 + span[2, end] ** 2))
        between = bend * (length / PLACES) ** 2 / 8.0
        worst = 0.0
        for place in range(PLACES + 1):
            x = length * place / PLACES
            while k < last - 1 and way[k + 1] < knots[j] + x:
                k += 1
                away = missed(span, length, way[k] - knots[j], points, 0.0, k)
                worst = max(worst, (away + between) / min(tolerance[k - 1], tolerance[k]))
            share = (knots[j] + x - way[k]) / (way[k + 1] - way[k])
            worst = max(worst, (missed(span, length, x, points, share, k) + between) / tolerance[k])
        if k > before + 1 and bend * length > WIDE and moved(controls, j + 1) and moved(controls, j + 2):
            worst = max(worst, bend * length / WIDE)
        if not worst <= 1.0:
            kept = False
            reach = 1
            while reach < 3:  # the nearest vertices that have to do with it
                low, high = k, k
                while low > first and way[low] >= knot(knots, spans, j - reach):
                    low -= 1
                while high < last and way[high] <= knot(knots, spans, j + 1 + reach):
                    high += 1
                if high - low > 1:
                    break
                reach += 1
            for other in range(low, high + 1):
                if knot(knots, spans, j - reach) <= way[other] <= knot(knots, spans, j + 1 + reach):
                    factor[other] = min(factor[other], MUCH if worst > FAR else LITTLE)
    return kept


@kernel
def fit(
    points: Array,
    way: Array,
    turn: Array,
    wanted: Array,
    tolerance: Array,
    missing: Array,
    size: Array,
    factor: Array,
    first: int,
    last: int,
    knots: Array,
    controls: Array,
    span: Array,
) -> int:
    """Find knots and control points for one polygon and return how many spans they make, as `splines` says.

    None where chords are so short that corners are not rounded each within its own.
    """
    way[first] = 0.0
    for k in range(first + 1, last + 1):
        way[k] += way[k - 1]
    widen(way, wanted, first, last)
    for k in range(first, last + 1):
        size[k] = min(size[k], wanted[k], way[last] - way[first])
    for attempt in range(ROUNDS + 1):
        if attempt == ROUNDS:
            for k in range(first + 1, last):
                short = min(way[k] - way[k - 1], way[k + 1] - way[k])
                size[k] = min(size[k], 0.5 * short, ALONE * MISSES * missing[k] / max(turn[k], 1e-300))
        grade(way, size, first, last)
        spans = knots_of(way, size, first, last, knots)
        controls_of(points, way, first, last, knots, spans, controls)
        if hold_to(points, way, tolerance, first, last, knots, spans, controls, span, factor):
            return spans
        for k in range(first, last + 1):
            size[k] *= factor[k]
    return 0


@kernel
def splines(
    points: Array,
    way: Array,
    turn: Array,
    wanted: Array,
    tolerance: Array,
    missing: Array,
    parted: Flags,
    size: Array,
    factor: Array,
    runs: Indices,
    knots: Array,
    controls: Array,
    span: Array,
    pieces: Array,
    rows: Indices,
) -> None:
    """Let a curve follow each polygon.

    Args:
        points: (M, 3), m, the vertices of all.
        way: (M,) length of the chord before each, m; becomes that of the polygon up to there.
        turn: (M,) by how much the direction changes at each, as the norm of the difference of unit vectors.
        wanted: (M,) how wide each corner has to be for the speed, m; 0 at ends; changed.
        tolerance: (M,) of the chord after each vertex, m.
        missing: (M,) by how much each vertex may be missed, m.
        parted: (M,) whether a piece has to end there.
        size: (M,) the same, how wide it may be, m; changed.
        factor: (M,) to work in.
        runs: (R + 1,) first vertex of each polygon, and M.
        knots: (K,) to work in, as many as three for each vertex.
        controls: (K + 3, 7) likewise.
        span: (3, 4) likewise.
        pieces: (P, 16) for the result, as many as four for each vertex: begin and end, m, place, and first and second
            derivative there, second derivative at the end, a chord that it follows, counted within its polygon, and the
            length of the span that it is of.
        rows: (R + 1,) for the first piece of each polygon, and how many there are; some may have none.
    """
    row = 0
    for run in range(runs.shape[0] - 1):
        rows[run] = row
        first, last = runs[run], runs[run + 1] - 1
        spans = fit(points, way, turn, wanted, tolerance, missing, size, factor, first, last, knots, controls, span)
        k = first
        for j in range(spans):
            write_span(knots, spans, controls, j, span)
            begin, length = knots[j], knots[j + 1] - knots[j]
            while begin < knots[j + 1]:
                end = knots[j + 1]
                while k < last and (way[k] <= begin or not parted[k]) and way[k] < end:
                    k += 1
                if begin < way[k] < end and parted[k]:
                    end = way[k]
                x, y = begin - knots[j], end - knots[j]
                pieces[row, 0], pieces[row, 1] = begin, end
                for axis in range(3):
                    c0, c1, c2, c3 = span[axis, 0], span[axis, 1], span[axis, 2], span[axis, 3]
                    third = (c3 - c2) / length
                    pieces[row, 2 + axis] = c0 + x * (c1 + x * (0.5 * c2 + x * third / 6.0))
                    pieces[row, 5 + axis] = c1 + x * (c2 + 0.5 * x * third)
                    pieces[row, 8 + axis] = c2 + x * third
                    pieces[row, 11 + axis] = c2 + y * third
                pieces[row, 14], pieces[row, 15] = float(k - 1 - first), length
                row += 1
                begin = end
    rows[runs.shape[0] - 1] = row
