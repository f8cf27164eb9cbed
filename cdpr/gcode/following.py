"""Motion along a path of many pieces with limited speed, acceleration and jerk, and a wanted speed on each piece.

Between two stops the position s(t) along the path has piecewise constant jerk (`pace`). Its limits leave room for the
path's curvature (`corners.caps`), so that the norms of velocity, acceleration and jerk of q(s(t)) respect theirs. The
motion is not time-optimal: at each increase of the speed, the acceleration falls to zero.

The motion is converted to quintics of time, like all motions: exactly for straight pieces, within EXACT otherwise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cdpr.base.errors import CdprError
from cdpr.gcode.corners import ALONE, AROUND, ROUND, caps, corners
from cdpr.gcode.course import Course
from cdpr.gcode.curves import Curves, Indices, together
from cdpr.gcode.pace import pace
from cdpr.gcode.smoothing import smoothed
from cdpr.model.robot import Array
from cdpr.trajectory.jerk_limited import Limits
from cdpr.trajectory.knots import quintic
from cdpr.trajectory.trajectory import COLUMNS, Trajectory, hold

# Largest deviation of a quintic from q(s(t)), m, and of its jerk as a share of the limit; planning of the path reserves
# that share.
EXACT, JERK_EXACT = 1e-10, 1e-3

# s; shorter phases are omitted: the motion in them is below round-off.
SHORTEST = 1e-11

# Pieces of which corners leave less than this share are omitted.
USED_UP = 1e-12

# Parts so short that round-off of their end positions and speeds, up to this share, would change the jerk by more than
# JERK_EXACT get a constant jerk from the accelerations at their ends.
ROUNDING = 1e-14

SAME = 1e-9  # relative difference of equal durations

MAX_SEGMENTS = 2_000_000  # 336 bytes each

CHUNK = 65536  # polynomials per batch, to limit memory

HALVINGS = 60  # bisections of a phase's duration to find the time at a position


def follow(
    start: float, course: Course, limits: Limits, orientation: Array, check: Callable[[], None] = lambda: None
) -> Trajectory:
    """Return the motion along a course from rest to rest, with constant attitude and within limits.

    The motion stops at corners that are neither smooth nor rounded. Corners are rounded within their tolerance, and as
    fast as limits allow, unless a stop takes less time.

    Args:
        start: start time, s.
        course: the path.
        limits: limits of the motion.
        orientation: (4,), attitude.
        check: called occasionally; it may raise to cancel.

    Raises:
        ValueError: if the course is empty.
        CdprError: if the motion needs more than MAX_SEGMENTS quintics.
    """
    if not len(course.pieces):
        raise ValueError("a course has one piece or more")
    plan = _planned(course, limits, check)
    if plan.rounded:
        exact = replace(course, tolerance=np.zeros(len(course.pieces)))
        slower = _slower(plan, _planned(exact, limits, check))
        if slower.any():
            tolerance = np.where(slower, 0.0, course.tolerance)
            tolerance[plan.ends] = 0.0  # stops remain stops, so that other chains do not change
            plan = _planned(replace(course, tolerance=tolerance), limits, check)
    phases, rows = plan.phases, plan.rows
    times = start + np.concatenate([[0.0], np.cumsum(phases[:, 0])[:-1]])
    pauses = np.concatenate([[0.0], np.cumsum(course.pause[plan.ends])[:-1]])
    times += np.repeat(pauses, np.diff(rows))
    chain = np.repeat(np.arange(len(rows) - 1), np.diff(rows))
    return _table(plan.path, phases, chain, times, limits.jerk, orientation, check)


@dataclass(frozen=True, eq=False)
class _Path:
    """Sections of a path: M sections in C chains, which are passed without a stop.

    Attributes:
        curves: curves of the sections.
        curve: curve of each section, (M,).
        offset: s of the curve at the section's beginning, m, (M,).
        starts: path positions of the beginnings and of the end, m, (M + 1,).
        speed: largest wanted speed, m/s, (M,).
        chains: first section of each chain, and M, (C + 1,).
        last: piece at the end of each chain, (C,).
    """

    curves: Curves
    curve: Indices
    offset: Array
    starts: Array
    speed: Array
    chains: Indices
    last: Indices


@dataclass(frozen=True, eq=False)
class _Plan:
    """Plan of a motion along a path.

    Attributes:
        path: path with C chains.
        phases: duration, s, then position, speed, acceleration at the beginning, and jerk, (P, 5).
        rows: first phase of each chain, and P, (C + 1,).
        ends: piece of the course at the end of each chain, (C,).
        rounded: True if the motion leaves the course anywhere.
    """

    path: _Path
    phases: Array
    rows: Indices
    ends: Indices
    rounded: bool


def _planned(course: Course, limits: Limits, check: Callable[[], None]) -> _Plan:
    """Return the plan with corners rounded where allowed."""
    fastest = min(limits.velocity, float(course.speed.max()))
    kept = Limits(fastest, (1.0 - JERK_EXACT) * limits.acceleration, (1.0 - JERK_EXACT) * limits.jerk)
    pieces, joined, source = smoothed(course, kept)
    check()
    cut, rounded = corners(pieces.pieces, np.where(joined, 0.0, pieces.tolerance[:-1]), pieces.speed, kept, check)
    path = _sections(pieces, joined, cut, rounded)
    used = path.curves.take(path.curve)
    share = _shares(path, used, len(pieces.pieces), kept)
    speeds = caps(used, path.speed, kept, np.where(share < 1.0, share, 0.0))
    check()
    return _Plan(
        path,
        *pace(path.starts, speeds, *_along(share, limits), path.chains),
        source[path.last],
        pieces.pieces is not course.pieces or len(rounded) > 0,
    )


def _slower(plan: _Plan, exact: _Plan) -> NDArray[np.bool_]:
    """Return True for pieces of chains that would be faster with a stop at each of their corners."""

    def ends(each: _Plan) -> Array:
        return np.concatenate([[0.0], np.cumsum(each.phases[:, 0])])[each.rows[1:]]

    without = ends(exact)[np.searchsorted(exact.ends, plan.ends)]
    slower = np.diff(ends(plan), prepend=0.0) > np.diff(without, prepend=0.0) * (1.0 + SAME)
    return np.repeat(slower, np.diff(plan.ends, prepend=-1))


def _sections(course: Course, smooth: NDArray[np.bool_], cut: Array, rounded: Curves) -> _Path:
    """Return pieces and rounded corners in their order."""
    count = len(course.pieces)
    none = np.zeros(1)
    begin, end = np.concatenate([none, cut]), np.concatenate([cut, none])
    corner = np.flatnonzero(cut > 0.0)
    # Sort keys: 2 i for piece i, 2 i + 1 for the corner at its end.
    order = np.concatenate([2 * np.arange(count), 2 * corner + 1])
    by_order = np.argsort(order)
    slow = np.minimum(course.speed[:-1], course.speed[1:])
    left = course.pieces.length - begin - end
    length = np.concatenate([left, 2.0 * cut[corner]])[by_order]
    curve = np.concatenate([np.arange(count), count + np.arange(len(corner))])[by_order]
    offset = np.concatenate([begin, np.zeros(len(corner))])[by_order]
    speed = np.concatenate([course.speed, slow[corner]])[by_order]
    # Pieces used up by their corners are omitted; their chain continues with the next corner.
    stays = np.concatenate([left > USED_UP * course.pieces.length, np.full(len(corner), True)])[by_order]
    goes_on = np.concatenate([smooth | (cut > 0.0), [False]])
    new = np.concatenate([[True], ~goes_on[:-1]])[order[by_order] // 2] & (order[by_order] % 2 == 0)
    chain = np.cumsum(new)[stays]
    chains = np.concatenate([[0], np.flatnonzero(np.diff(chain)) + 1, [len(chain)]])
    starts = np.concatenate([none, np.cumsum(length[stays])])
    last = np.flatnonzero(~goes_on)
    curves = together([course.pieces, rounded])
    return _Path(curves, curve[stays], offset[stays], starts, speed[stays], chains, last)


def _shares(path: _Path, used: Curves, pieces: int, limits: Limits) -> Array:
    """Return the shares of acceleration and jerk for changes of speed in sections, (M,); 1 in straight ones."""
    straight = used.bounds[:, 1] == 0.0
    share = np.where(straight, 1.0, np.where(path.curve < pieces, ROUND, AROUND))
    # Zones of sections that are all straight or all curved. A curved zone is single if the lines on both sides are long
    # enough for any change of speed.
    new = np.concatenate([[True], straight[1:] != straight[:-1]])
    new[path.chains[:-1]] = True
    first = np.flatnonzero(new)
    length = np.add.reduceat(np.diff(path.starts), first)
    cap = np.minimum.reduceat(caps(used, path.speed, limits, np.full(len(share), ALONE)), first)
    a, j = limits.acceleration, limits.jerk
    needed = 0.5 * cap * np.where(cap * j >= a * a, cap / a + a / j, 2.0 * np.sqrt(cap / j))
    beside = np.where(straight[first], length, 0.0)
    chain = np.searchsorted(path.chains, first, side="right")
    same = np.concatenate([[False], chain[1:] == chain[:-1], [False]])
    around = np.concatenate([[0.0], beside, [0.0]])
    short = np.minimum(np.where(same[:-1], around[:-2], 0.0), np.where(same[1:], around[2:], 0.0))
    alone = (short >= needed) & (share[first] == ROUND)
    return np.where(np.repeat(alone, np.diff(np.append(first, len(share)))), ALONE, share)


def _along(share: Array, limits: Limits) -> tuple[Array, Array]:
    """Return acceleration and jerk along the path, (N,) each, for shares (N,), which are 1 in straight sections."""
    whole = share * np.where(share < 1.0, 1.0 - JERK_EXACT, 1.0)
    return whole * limits.acceleration, whole * limits.jerk


def _state(phases: Array, time: Array) -> tuple[Array, Array, Array]:
    """Return s - s(0), s' and s'' of phases (K, 5) at times (K,) after their beginnings."""
    _, _, v, a, jerk = phases.T
    return (
        time * (v + time * (0.5 * a + time * jerk / 6.0)),
        v + time * (a + 0.5 * time * jerk),
        a + time * jerk,
    )


def _table(
    path: _Path,
    phases: Array,
    chain: Indices,
    times: Array,
    jerk: float,
    orientation: Array,
    check: Callable[[], None],
) -> Trajectory:
    """Return the trajectory of phases (P, 5) of chains (P,) that begin at times (P,), s."""
    phase, begin = _parts(path.starts, phases)
    following = np.concatenate([phase[1:] == phase[:-1], [False]])
    end = np.where(following, np.concatenate([begin[1:], [0.0]]), phases[phase, 0])
    long = end - begin > SHORTEST
    phase, begin, end = phase[long], begin[long], end[long]
    if not len(phase):
        return hold(path.curves.at(path.curve[:1], path.offset[:1])[0][0], orientation)
    middle = phases[phase, 1] + _state(phases[phase], 0.5 * (begin + end))[0]
    section = np.searchsorted(path.starts, middle, side="right") - 1
    # near a stop, round-off may select the next chain, which has another direction
    section = np.clip(section, path.chains[chain[phase]], path.chains[chain[phase] + 1] - 1)
    many = _divided(path, phases[phase], begin, end, section, jerk)
    if not many.sum() <= MAX_SEGMENTS:
        raise CdprError(
            f"the motion takes {many.sum():.3g} polynomials of time, {MAX_SEGMENTS} at most are allowed: divide the "
            "path, or round it less finely"
        )
    last = np.cumsum(many.astype(np.int64))
    rows = np.empty((int(last[-1]), COLUMNS))
    rows[:, 38:] = orientation
    for row in range(0, len(rows), CHUNK):
        check()
        number = np.arange(row, min(row + CHUNK, len(rows)))
        which = np.searchsorted(last, number, side="right")
        step, whole = number - last[which] + many[which], (end - begin)[which] / many[which]
        first, part = begin[which] + whole * step, phases[phase[which]]
        rows[number, 0], rows[number, 1] = times[phase[which]] + first, whole
        rows[number, 2:20] = _polynomials(path, part, first, whole, section[which], jerk)
        rows[number, 20:38] = 0.0
    return Trajectory(rows)


def _polynomials(path: _Path, phases: Array, first: Array, share: Array, section: Indices, jerk: float) -> Array:
    """Return polynomials (K, 18) of durations `share`, which begin at times `first` of phases (K, 5) in sections."""
    curve = path.curve[section]
    way, v0, a0 = _state(phases, first)
    s = phases[:, 1] + way - path.starts[section] + path.offset[section]
    x, d, dd = path.curves.at(curve, s)
    h, v, a = share[:, None], d * v0[:, None], d * a0[:, None] + dd * v0[:, None] ** 2
    none = np.zeros_like(x)
    # straight parts are cubics
    found = np.stack([x, v * h, 0.5 * a * h**2, d * phases[:, 4:] * h**3 / 6.0, none, none], axis=2).reshape(-1, 18)
    bent = np.flatnonzero(path.curves.bounds[curve, 1] > 0.0)
    curve, s, share, v0, a0, phases = curve[bent], s[bent], share[bent], v0[bent], a0[bent], phases[bent]
    h, x, v, a = h[bent], x[bent], v[bent], a[bent]
    ds = share * (v0 + share * (0.5 * a0 + share * phases[:, 4] / 6.0))
    _, v1, a1 = _state(phases, first[bent] + share)
    _, d1, dd1 = path.curves.at(curve, s + ds)
    end = d1 * a1[:, None] + dd1 * v1[:, None] ** 2
    polynomials = quintic(h, x, path.curves.way(curve, s, ds), v, d1 * v1[:, None], a, end)
    brief = JERK_EXACT * jerk * share**2 < ROUNDING * v0
    level = np.stack([x, v * h, 0.5 * a * h**2, (end - a) * h**2 / 6.0, 0.0 * x, 0.0 * x], axis=2).reshape(-1, 18)
    found[bent] = np.where(brief[:, None], level, polynomials)
    return found


def _parts(starts: Array, phases: Array) -> tuple[Indices, Array]:
    """Split phases at the ends of sections; return each part's phase, in order, and its beginning in the phase, s."""
    inner = starts[1:-1]
    within = np.clip(np.searchsorted(phases[:, 1], inner, side="right") - 1, 0, len(phases) - 1)
    part, away = phases[within], inner - phases[within, 1]
    low, high = np.zeros(len(inner)), part[:, 0].copy()
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        before = _state(part, middle)[0] < away
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    phase = np.concatenate([np.arange(len(phases)), within])
    begin = np.concatenate([np.zeros(len(phases)), high])
    order = np.lexsort((begin, phase))
    return phase[order], begin[order]


def _divided(path: _Path, phases: Array, begin: Array, end: Array, section: Indices, jerk: float) -> Array:
    """Return the number of quintics of each part.

    The largest error of Hermite interpolation is h^6 max|p^(6)| / 46080, and that of its third derivative, at the ends,
    h^3 max|p^(6)| / 120, here doubled. The sixth derivative of q(s(t)) is bounded by Faa di Bruno's formula with s''''
    = 0.
    """
    k2, k3, k4, k5, k6 = path.curves.bounds[path.curve[section], 1:].T
    (_, v0, a0), (_, v1, a1) = _state(phases, begin), _state(phases, end)
    v, a, j = np.maximum(v0, v1), np.maximum(np.abs(a0), np.abs(a1)), np.abs(phases[:, 4])
    sixth = (
        k2 * 10.0 * j**2
        + k3 * (15.0 * a**3 + 60.0 * v * a * j)
        + k4 * (45.0 * v**2 * a**2 + 20.0 * v**3 * j)
        + k5 * 15.0 * v**4 * a
        + k6 * v**6
    )
    needed = np.maximum((sixth / (46080.0 * EXACT)) ** (1.0 / 6.0), (sixth / (60.0 * JERK_EXACT * jerk)) ** (1.0 / 3.0))
    return np.asarray(np.maximum(np.ceil(needed * (end - begin)), 1.0))
