"""Conversion of consecutive lines to one curve: a cubic B-spline within the tolerance of their corners.

Many short chords become few wide spans, as far as the tolerance allows (LinuxCNC merges lines for the same reason with
its naive CAM detector). A corner of long lines becomes two spans, as wide as its tolerance allows and its speed needs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cdpr.gcode.course import Course
from cdpr.gcode.curves import Curves, Indices, cubics, lines, together
from cdpr.gcode.polygon_splines import polygon_splines
from cdpr.gcode.rounding_gain import MISSES, rounded_widths
from cdpr.model.robot import Array
from cdpr.trajectory.jerk_limited import Limits

# Pieces meet smoothly if their directions differ by less, and their curvatures by less of themselves: decimal points
# deviate from a straight line by rounding. The remaining step is 1e-9 of the speed.
SMOOTH = 1e-9

# Factor of a corner's width over the width that its speed needs, if its tolerance allows.
AMPLE = 3.0

# m, smallest necessary width of a corner: directions from such close points are precise to 1e-10.
NARROW = 1e-5

SHORT = 4e-6  # m; corners beside shorter lines may have no room to be rounded

# Corners with neighbours that turn in the same direction, within this factor, may be WIDER times wider.
ALIKE, WIDER = 4.0, 8.0

INNER, OUTER = 0.25, 0.5  # shares of a half chord for the sizes of its ends, so that the curve continues straight


@dataclass(frozen=True, eq=False)
class _Runs:
    """Lines that become one curve each: R runs.

    Attributes:
        first: first line of each run, (R,).
        last: last line of each run, (R,).
        goes_on: True if the motion does not stop before the first and after the last line, (R, 2).
    """

    first: Indices
    last: Indices
    goes_on: NDArray[np.bool_]


def smoothed(course: Course, limits: Limits) -> tuple[Course, NDArray[np.bool_], Indices]:
    """Return a course with curves instead of lines where tolerances allow.

    No curve is farther from its lines than their tolerances. A single corner that would take more time than a stop
    remains a stop.

    Returns:
        The course of N pieces; True for pieces that join the next one smoothly, (N - 1,); the original piece of each,
            (N,).
    """
    pieces, count = course.pieces, len(course.pieces)
    smooth, turn = _meeting(pieces)
    inner = slice(None, -1)
    tolerance = np.where(course.stop, 0.0, course.tolerance)
    widths = rounded_widths(course, np.maximum(turn, SMOOTH), limits)
    tolerance[inner][~smooth & (widths == 0.0)] = 0.0
    course = replace(course, tolerance=tolerance)
    runs = _runs(course, smooth)
    if not len(runs.first):
        return course, smooth & ~course.stop[inner], np.arange(count)
    curves, owner, run, breaks = _curved(course, turn, widths, runs, limits)
    beside = np.stack([runs.first - 1, runs.last], axis=1)  # corners before and behind each
    stops = breaks & ~smooth[np.clip(beside, 0, count - 2)]
    without = (np.bincount(run, minlength=len(runs.first)) == 0) | (breaks & ~stops).any(axis=1)
    if stops.any():
        tolerance[beside[stops]] = 0.0
        return smoothed(course, limits)
    if without.any():
        # add stops beside too short lines, or at all corners if that does not help
        within = np.zeros(count, dtype=np.int64)
        np.add.at(within, runs.first[without], 1)
        np.add.at(within, runs.last[without], -1)
        sharp = (np.cumsum(within)[inner] > 0) & ~smooth & (tolerance[inner] > 0.0)
        short = sharp & (np.minimum(pieces.length[:-1], pieces.length[1:]) < SHORT)
        tolerance[inner][short if short.any() else sharp] = 0.0
        return smoothed(course, limits)
    heads, tails = np.flatnonzero(runs.goes_on[:, 0]), np.flatnonzero(runs.goes_on[:, 1])
    halves = together([_halves(pieces, runs.first[heads], 0.0), _halves(pieces, runs.last[tails], 0.5)])
    number = np.full(count + 1, 0)  # number of runs that contain each line
    np.add.at(number, runs.first, 1)
    np.add.at(number, runs.last + 1, -1)
    alone = np.flatnonzero(np.cumsum(number[:-1]) == 0)
    # In order: for each run its first half line, its curves, and its last half line.
    source = np.concatenate([alone, runs.first[heads], runs.last[tails], owner])
    place = np.concatenate([3 * alone, 3 * runs.first[heads], 3 * runs.last[tails] + 2, 3 * runs.first[run] + 1])
    whose = np.concatenate([np.full(len(alone), -1), heads, tails, run])
    order = np.argsort(place, kind="stable")
    source, whose = source[order], whose[order]
    same = (whose[1:] == whose[:-1]) & (whose[1:] >= 0)
    ends = np.concatenate([~same, [True]])
    joined = same.copy()
    joined[~same] = (smooth & ~course.stop[inner])[source[inner][~same]]
    return (
        Course(
            together([pieces.take(alone), halves, curves]).take(order),
            course.speed[source],
            np.where(ends, course.tolerance[source], 0.0),
            ends & course.stop[source],
            np.where(ends, course.pause[source], 0.0),
        ),
        joined,
        source,
    )


def _meeting(pieces: Curves) -> tuple[NDArray[np.bool_], Array]:
    """Return whether pieces meet smoothly, (N - 1,), and the differences of their directions."""
    count = len(pieces)
    _, d0, dd0 = pieces.at(np.arange(count - 1), pieces.length[:-1])
    _, d1, dd1 = pieces.at(np.arange(1, count), np.zeros(count - 1))
    turn = np.linalg.norm(d1 - d0, axis=1)
    bend = np.linalg.norm(dd1 - dd0, axis=1)
    smooth = (turn <= SMOOTH) & (bend <= SMOOTH * (np.linalg.norm(dd0, axis=1) + np.linalg.norm(dd1, axis=1)))
    return smooth, turn


def _runs(course: Course, smooth: NDArray[np.bool_]) -> _Runs:
    """Return the longest sequences of lines with tolerances at corners; straight continuations remain unchanged."""
    pieces = course.pieces
    straight = pieces.bounds[:, 1] == 0.0
    passed = ~course.stop[:-1] & (smooth | (course.tolerance[:-1] > 0.0))
    linked = passed & (course.tolerance[:-1] > 0.0) & straight[:-1] & straight[1:]
    edges = np.diff(np.concatenate([[False], linked, [False]]).astype(np.int8))
    first, last = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    bends = np.concatenate([[0], np.cumsum(linked & ~smooth)])
    some = bends[last] > bends[first]
    first, last = first[some], last[some]
    none = np.array([False])
    goes_on = np.stack([np.concatenate([none, passed])[first], np.concatenate([passed, none])[last]], axis=1)
    return _Runs(first, last, goes_on)


def _in_curves(pieces: Curves, corner: Indices, turn: Array) -> NDArray[np.bool_]:
    """Return True for corners (K,) that turn like both neighbours."""
    _, direction, _ = pieces.at(np.arange(len(pieces)), np.zeros(len(pieces)))
    change = np.zeros((len(turn) + 2, 3))
    change[1:-1] = np.diff(direction, axis=0)
    here = change[corner + 1]
    likewise = np.ones(len(corner), dtype=bool)
    for beside in (change[corner], change[corner + 2]):
        size = np.linalg.norm(beside, axis=1)
        likewise &= (
            (np.sum(here * beside, axis=1) > 0.0) & (size < ALIKE * turn[corner]) & (ALIKE * size > turn[corner])
        )
    return likewise


def _halves(pieces: Curves, which: Indices, begin: float) -> Curves:
    """Return the halves of lines (K,) that begin at this share of them."""
    length = pieces.length[which]
    ends = (pieces.at(which, share * length)[0] for share in (begin, begin + 0.5))
    return lines(*ends)


def _curved(
    course: Course, turn: Array, widths: Array, runs: _Runs, limits: Limits
) -> tuple[Curves, Indices, Indices, NDArray[np.bool_]]:
    """Return the curves of all runs, the line that defines the speed of each, and its run.

    The last result is True for ends of a run whose adjacent line the curve does not follow straight, (R, 2).
    """
    pieces, many = course.pieces, runs.last - runs.first + 1
    starts = np.concatenate([[0], np.cumsum(many + 1)])
    total, ends = int(starts[-1]), starts[1:] - 1
    # line after each vertex; for the last vertex of a run the line before it
    line = np.arange(total) - np.repeat(starts[:-1] - runs.first, many + 1)
    line[ends] -= 1
    share = np.zeros(total)
    share[starts[:-1]] = np.where(runs.goes_on[:, 0], 0.5, 0.0)
    share[ends] = np.where(runs.goes_on[:, 1], 0.5, 1.0)
    points = np.ascontiguousarray(pieces.at(line, share * pieces.length[line])[0])
    lengths = np.concatenate([[0.0], np.linalg.norm(np.diff(points, axis=0), axis=1)])
    chord = np.stack([lengths[starts[:-1] + 1], lengths[ends]], axis=1)
    inner = np.ones(total, dtype=bool)
    inner[starts[:-1]] = inner[ends] = False
    corner = line[inner] - 1
    turns, missing = np.zeros(total), np.full(total, np.inf)
    turns[inner], missing[inner] = turn[corner], course.tolerance[corner]
    speed = np.minimum(np.minimum(course.speed[corner], course.speed[corner + 1]), limits.velocity)
    wanted, parted = np.zeros(total), np.zeros(total, dtype=bool)
    wanted[inner] = AMPLE * np.maximum(
        turn[corner] * speed**2 / limits.acceleration, np.sqrt(turn[corner] * speed**3 / limits.jerk)
    )
    wanted[inner] = np.maximum(wanted[inner], np.where(turn[corner] > SMOOTH, NARROW, 0.0))
    parted[inner] = course.speed[corner] != course.speed[corner + 1]
    size = MISSES * missing / np.maximum(turns, SMOOTH)
    size[inner] = np.minimum(size[inner], widths[corner])
    size[inner] *= np.where(_in_curves(pieces, corner, turn), WIDER, 1.0)
    for side, (end, step) in enumerate(((starts[:-1], 1), (ends, -1))):
        on = runs.goes_on[:, side]
        wanted[end[on]] = size[end[on]] = INNER * chord[on, side]
        size[end[on] + step] = np.minimum(size[end[on] + step], OUTER * chord[on, side])
    chords = np.minimum(missing, np.concatenate([missing[1:], [np.inf]]))
    found, rows = polygon_splines(points, lengths, turns, wanted, size, chords, missing, parted, starts)
    run = np.repeat(np.arange(len(many)), np.diff(rows))
    begin = found[:, 2:5], found[:, 5:8], found[:, 8:11]
    curves = cubics(found[:, 1] - found[:, 0], begin, found[:, 11:14], found[:, 15])
    owner = found[:, 14].astype(np.int64) + runs.first[run]
    return curves, owner, run, runs.goes_on & (_reach(found[:, 15], rows) > chord)


def _reach(span: Array, rows: Indices) -> Array:
    """Return the distance of the first three control points from the ends of each run, m, (R, 2).

    If all three are on one line, direction and curvature at the end are those of the line.
    """
    reach = np.zeros((len(rows) - 1, 2))
    some = np.flatnonzero(np.diff(rows))
    first, last = rows[some], rows[some + 1] - 1
    more = last > first
    for side, (end, step) in enumerate(((first, 1), (last, -1))):
        reach[some, side] = 2.0 * span[end] / 3.0
        reach[some[more], side] += span[(end + step)[more]] / 3.0
    return reach
