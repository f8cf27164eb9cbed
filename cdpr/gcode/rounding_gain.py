"""Time of rounding a single corner of two lines, compared with a stop."""

from __future__ import annotations

import numpy as np

from cdpr.gcode.course import Course
from cdpr.model.robot import Array
from cdpr.trajectory.jerk_limited import Limits

# A single corner of size h, rounded from h before to h after it, deviates by h / MISSES times its turn.
MISSES = 6.0

# A corner is single if its size is at most this multiple of its shorter line; others merge with their neighbours.
MERGED = 2.0

# Candidate sizes, as shares of the largest.
SIZES = (1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12)

# m; narrower corners are not rounded.
NARROWEST = 1e-6

# Shares of acceleration and jerk for a single corner's curvature (`corners.ALONE`).
BENT, BENT_JERK = 0.95, 0.85


def rounded_widths(course: Course, sharp: Array, limits: Limits) -> Array:
    """Return the widths of rounded corners between N pieces, m, (N - 1,).

    A width of 0 means a stop, an infinite one the largest that is allowed. The time of a corner is that of both changes
    of speed and of its length at its speed, less the time of the same distance at full speed, which is the speed
    reached on the line between two stops.

    Args:
        course: the pieces; only single corners of lines are judged, others are always rounded.
        sharp: differences of their directions, (N - 1,), positive.
        limits: limits of the motion.
    """
    length = course.pieces.length
    shorter = np.minimum(length[:-1], length[1:])
    allowed = MISSES * course.tolerance[:-1] / sharp
    largest = np.minimum(allowed, 0.5 * shorter)
    slower = np.minimum(course.speed[:-1], course.speed[1:])
    full = [
        np.minimum(np.minimum(_reached(way, limits), speed), limits.velocity)
        for way, speed in ((length[:-1], course.speed[:-1]), (length[1:], course.speed[1:]))
    ]
    least = sum(_lost(speed, np.zeros(len(sharp)), limits) for speed in full)
    best = np.zeros(len(sharp))
    for share in SIZES:
        size = share * largest
        speed = np.cbrt(BENT_JERK * limits.jerk * size**2 / sharp)
        speed = np.minimum(np.minimum(speed, np.sqrt(BENT * limits.acceleration * size / sharp)), slower)
        cost = np.zeros(len(sharp))
        for fast in full:
            slow = np.minimum(speed, fast)
            with np.errstate(divide="ignore", invalid="ignore"):
                cost += _lost(fast, slow, limits) + size / slow - size / fast
        better = (cost < least) & (size >= NARROWEST)
        best, least = np.where(better, size, best), np.where(better, cost, least)
    return np.where((allowed > MERGED * shorter) | (best == largest), np.inf, best)


def _reached(way: Array, limits: Limits) -> Array:
    """Return the speed, m/s, reached within a distance, m, between two stops, with or without constant acceleration."""
    rise = limits.acceleration / limits.jerk
    steady = 0.5 * limits.acceleration * (np.sqrt(rise**2 + 4.0 * way / limits.acceleration) - rise)
    return np.where(steady >= limits.acceleration * rise, steady, np.cbrt(0.25 * limits.jerk * way**2))


def _lost(fast: Array, slow: Array, limits: Limits) -> Array:
    """Return the time, s, that a change of speed loses against the faster speed over the same distance."""
    change, rise = fast - slow, limits.acceleration / limits.jerk
    steady = change >= limits.acceleration * rise
    time = np.where(steady, change / limits.acceleration + rise, 2.0 * np.sqrt(change / limits.jerk))
    return np.asarray(time * change / (2.0 * fast))
