"""Corners between pieces of a path: passed unchanged, rounded within a tolerance, or stops."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cdpr.gcode.curves import PLACES, Curves, Indices, joining, together
from cdpr.model.robot import Array
from cdpr.trajectory.jerk_limited import Limits

# Share of acceleration and jerk for changes of speed: on curves, on corners beside curved pieces, and on single corners
# between long lines, which leave room for changes of speed. The rest is for the path's curvature. On curves both are
# nearly perpendicular (0.6^2 + 0.8^2 = 1); on corners they may add up.
ROUND, AROUND, ALONE = 0.6, 0.3, 0.1

TRIES, SMALLER = 24, 0.5**0.5  # number of sizes of a rounded corner, and their ratio
CHUNK = 4096  # corners per batch, to limit memory
# Speed caps are found by bisection of the exponent, down to 2^-MAGNITUDES of the wanted speed.
MAGNITUDES, HALVINGS = 200.0, 60

# Corners shorter than this share of a piece are omitted; smaller relative differences count as equal.
LEAST = 1e-9


def corners(
    pieces: Curves, tolerance: Array, speed: Array, limits: Limits, check: Callable[[], None] = lambda: None
) -> tuple[Array, Curves]:
    """Return the length that each corner between N pieces takes from both, (N - 1,), m, and the rounded corners.

    A rounded corner is a quintic that meets position, direction and curvature of both pieces at the same distance from
    the corner. Between straight pieces it is the fastest corner of all polynomials of its degree with continuous
    acceleration. It is the smallest one that is passed at the wanted speed, or else the fastest within the tolerance.

    Args:
        pieces: contiguous pieces.
        tolerance: allowed distance of the path from each corner, m, (N - 1,); 0 for exact corners.
        speed: wanted speed on each piece, m/s, (N,).
        limits: limits of the motion.
        check: called occasionally; it may raise to cancel.
    """
    cut = np.zeros(len(pieces) - 1)
    wanted = np.flatnonzero(tolerance > 0.0)
    parts: list[Curves] = []
    for begin in range(0, len(wanted), CHUNK):
        check()
        part = wanted[begin : begin + CHUNK]
        cut[part], curve = _rounded(pieces, part, tolerance[part], speed, limits)
        parts.append(curve.take(cut[part] > 0.0))
    nothing = pieces.take(np.zeros(0, dtype=np.int64))
    return cut, together(parts) if parts else nothing


def caps(pieces: Curves, speed: Array, limits: Limits, share: Array) -> Array:
    """Return the largest speeds (N,), m/s, on pieces while the speed changes; 0 if there is none.

    `share` (N,) is the share of acceleration and jerk used along the path. p = q(s(t)) has p'' = q'' v^2 + q' s'' and
    p''' = q''' v^3 + 3 q'' v s'' + q' s''', whose norms are bounded.
    """
    high = np.minimum(speed, limits.velocity) / pieces.bounds[:, 0]
    left = np.flatnonzero(~_kept(pieces, high, limits, share))
    if len(left):
        pieces, share, most = pieces.take(left), share[left], high[left]
        slow, fast = np.full_like(most, MAGNITUDES), np.zeros_like(most)  # number of halvings
        for _ in range(HALVINGS):
            middle = 0.5 * (slow + fast)
            within = _kept(pieces, most * np.exp2(-middle), limits, share)
            slow, fast = np.where(within, middle, slow), np.where(within, fast, middle)
        found = most * np.exp2(-slow)
        high[left] = np.where(_kept(pieces, found, limits, share), found, 0.0)
    return high


def _kept(pieces: Curves, v: Array, limits: Limits, share: Array) -> NDArray[np.bool_]:
    """Return True if limits are satisfied at speeds v (N,), m/s, while the speed changes."""
    k1, k2, k3 = pieces.bounds[:, 0], pieces.bounds[:, 1], pieces.bounds[:, 2]
    skew, turned = pieces.skew.T
    j = share * limits.jerk
    # A speed change by v needs an acceleration of at most sqrt(j v).
    a = np.minimum(share * limits.acceleration, np.sqrt(j * limits.velocity))
    inward, along, across = k2 * v**2, k1 * j + k3 * v**3, 3.0 * k2 * v * a
    second = (a * k1) ** 2 + inward**2 + 2.0 * skew * a * k1 * inward
    third = along**2 + across**2 + 2.0 * across * (skew * k1 * j + turned * k3 * v**3)
    return np.asarray((second <= limits.acceleration**2) & (third <= limits.jerk**2))


def _rounded(pieces: Curves, which: Indices, tolerance: Array, speed: Array, limits: Limits) -> tuple[Array, Curves]:
    """Return the length that each rounded corner takes from both pieces, (K,), m, and the corners."""
    wanted = np.minimum(np.minimum(speed[which], speed[which + 1]), limits.velocity)
    most = 0.5 * np.minimum(pieces.length[which], pieces.length[which + 1])
    # Between straight pieces the corner's middle deviates by 3/32 of its length times the turn.
    turn = np.linalg.norm(pieces.at(which + 1, 0.0 * most)[1] - pieces.at(which, pieces.length[which])[1], axis=1)
    size = np.minimum(most, 16.0 / 3.0 * tolerance / np.maximum(turn, 1e-300))
    best, cut, curve = np.zeros(len(which)), np.zeros(len(which)), _corner(pieces, which, size)
    left = np.arange(len(which))
    for _ in range(TRIES):
        tried = _corner(pieces, which[left], size[left])
        cap = caps(tried, wanted[left], limits, np.full(len(left), AROUND))
        allowed = _missed(pieces, which[left], tried, size[left]) <= tolerance[left] * (1.0 + LEAST)
        allowed &= (size > LEAST * most)[left] & (cap > 0.0)
        fast = allowed & (cap * tried.bounds[:, 0] >= wanted[left] * (1.0 - LEAST))
        # of equally fast corners the smallest, which is closest to the path
        better = fast | (allowed & (cap > best[left]))
        chosen = left[better]
        best[chosen], cut[chosen] = cap[better], size[chosen]
        curve.replace(chosen, tried.take(better))
        left = left[fast | ~allowed]
        size[left] *= SMALLER
        if not len(left):
            break
    return cut, curve


def _corner(pieces: Curves, which: Indices, size: Array) -> Curves:
    """Return rounded corners (K,), each from `size` before to `size` after the corner."""
    return joining(2.0 * size, pieces.at(which, pieces.length[which] - size), pieces.at(which + 1, size))


def _missed(pieces: Curves, which: Indices, rounded: Curves, size: Array) -> Array:
    """Return an upper bound of the distance between rounded corners and the path, at the same s, (K,), m."""
    missed = np.zeros(len(which))
    index = np.arange(len(which))
    for share in np.linspace(0.0, 1.0, PLACES + 1):
        s = 2.0 * share * size
        if share <= 0.5:
            place, _, _ = pieces.at(which, pieces.length[which] - size + s)
        else:
            place, _, _ = pieces.at(which + 1, s - size)
        missed = np.maximum(missed, np.linalg.norm(rounded.at(index, s)[0] - place, axis=1))
    return missed
