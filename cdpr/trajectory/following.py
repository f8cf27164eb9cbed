"""Along a path of many pieces with limited speed, acceleration and jerk, each piece at the speed that is wanted.

Between two stops the way s(t) along the path has piecewise constant jerk (`pace`), with limits that leave
room for the path's own curvature (`corners.caps`), so that norms of velocity, acceleration and jerk of q(s(t)) keep
theirs. It is not the fastest such motion: where speeds rise in steps, the acceleration falls to zero at each.

The motion becomes quintics of time, as all others: of straight pieces exactly, of others within EXACT of the path.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cdpr.errors import CdprError
from cdpr.model.robot import Array
from cdpr.trajectory.corners import ALONE, AROUND, ROUND, caps, corners
from cdpr.trajectory.course import Course
from cdpr.trajectory.curves import Curves, Indices, together
from cdpr.trajectory.jerk_limited import Limits
from cdpr.trajectory.knots import quintic
from cdpr.trajectory.pace import pace
from cdpr.trajectory.smoothing import smoothed
from cdpr.trajectory.trajectory import COLUMNS, Trajectory, hold

# How far a quintic may be from q(s(t)), m, and its jerk from that of q(s(t)), as a share of the limit; of which the
# path's planning takes that much less.
EXACT, JERK_EXACT = 1e-10, 1e-3

# Phases shorter than this, s, are left out: the motion moves by less than rounding meanwhile.
SHORTEST = 1e-11

# A piece of which less is left than this share is used up by its corners.
USED_UP = 1e-12

# Parts so brief that rounding of their ends' places and speeds, up to this share of them, would make more of the jerk
# than JERK_EXACT have one jerk, from the acceleration at one end to that at the other.
ROUNDING = 1e-14

SAME = 1e-9  # durations that differ by less of themselves are equal

MAX_SEGMENTS = 2_000_000  # of 336 bytes each

CHUNK = 65536  # polynomials that are made at once: memory

HALVINGS = 60  # of a phase's duration, in which the time at a place is looked for


def follow(
    start: float, course: Course, limits: Limits, orientation: Array, check: Callable[[], None] = lambda: None
) -> Trajectory:
    """Follow a course from `start` (s) on, from rest to rest, with one attitude (4,), within limits.

    At a corner that is neither smooth nor rounded the motion stops. Corners are rounded within their tolerance, and as
    fast as limits allow, where that takes no more time than stopping at them. CdprError where that takes more than
    MAX_SEGMENTS quintics. Calls `check` now and then, which may raise to give up.
    """
    if not len(course.pieces):
        raise ValueError("a course has one piece or more")
    plan = _planned(course, limits, check)
    if plan.rounded:
        exact = replace(course, tolerance=np.zeros(len(course.pieces)))
        slower = _slower(plan, _planned(exact, limits, check))
        if slower.any():
            tolerance = np.where(slower, 0.0, course.tolerance)
            tolerance[plan.ends] = 0.0  # what stopped there stops again: the other chains stay what they are
            plan = _planned(replace(course, tolerance=tolerance), limits, check)
    phases, rows = plan.phases, plan.rows
    times = start + np.concatenate([[0.0], np.cumsum(phases[:, 0])[:-1]])
    pauses = np.concatenate([[0.0], np.cumsum(course.pause[plan.ends])[:-1]])
    times += np.repeat(pauses, np.diff(rows))
    chain = np.repeat(np.arange(len(rows) - 1), np.diff(rows))
    return _table(plan.path, phases, chain, times, limits.jerk, orientation, check)


@dataclass(frozen=True, eq=False)
class _Path:
    """Sections of a path, M in C chains, which are passed without a stop.

    Attributes:
        curves: what they are parts of.
        curve: of which each is a part, (M,).
        offset: s of the curve at its beginning, m, (M,).
        starts: along the path, of beginnings and of the end, m, (M + 1,).
        speed: largest that is wanted, m/s, (M,).
        chains: first section of each chain, and M, (C + 1,).
        last: piece at which each chain ends, (C,).
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
    """How a path is passed.

    Attributes:
        path: with C chains.
        phases: duration, s, and speed, acceleration at the beginning, jerk, (P, 5).
        rows: first phase of each chain, and P, (C + 1,).
        ends: piece of the course at which each chain ends, (C,).
        rounded: whether it leaves the course anywhere.
    """

    path: _Path
    phases: Array
    rows: Indices
    ends: Indices
    rounded: bool


def _planned(course: Course, limits: Limits, check: Callable[[], None]) -> _Plan:
    """Round what may be rounded, and find how fast it can be passed."""
    fastest = min(limits.velocity, float(course.speed.max()))
    kept = Limits(fastest, (1.0 - JERK_EXACT) * limits.acceleration, (1.0 - JERK_EXACT) * limits.jerk)
    made, joined, source = smoothed(course, kept)
    check()
    cut, rounded = corners(made.pieces, np.where(joined, 0.0, made.tolerance[:-1]), made.speed, kept, check)
    path = _sections(made, joined, cut, rounded)
    used = path.curves.take(path.curve)
    share = _shares(path, used, len(made.pieces), kept)
    speeds = caps(used, path.speed, kept, np.where(share < 1.0, share, 0.0))
    check()
    return _Plan(
        path,
        *pace(path.starts, speeds, *_along(share, limits), path.chains),
        source[path.last],
        made.pieces is not course.pieces or len(rounded) > 0,
    )


def _slower(plan: _Plan, exact: _Plan) -> NDArray[np.bool_]:
    """Return of each piece whether it belongs to a chain that would be faster with a stop at each of its corners."""

    def ends(each: _Plan) -> Array:
        return np.concatenate([[0.0], np.cumsum(each.phases[:, 0])])[each.rows[1:]]

    without = ends(exact)[np.searchsorted(exact.ends, plan.ends)]
    slower = np.diff(ends(plan), prepend=0.0) > np.diff(without, prepend=0.0) * (1.0 + SAME)
    return np.repeat(slower, np.diff(plan.ends, prepend=-1))


def _sections(course: Course, smooth: NDArray[np.bool_], cut: Array, rounded: Curves) -> _Path:
    """Put pieces and rounded corners in their order."""
    count = len(course.pieces)
    none = np.zeros(1)
    begin, end = np.concatenate([none, cut]), np.concatenate([cut, none])
    corner = np.flatnonzero(cut > 0.0)
    # Keys of order: 2 i for piece i, 2 i + 1 for the corner at its end.
    order = np.concatenate([2 * np.arange(count), 2 * corner + 1])
    by_order = np.argsort(order)
    slow = np.minimum(course.speed[:-1], course.speed[1:])
    left = course.pieces.length - begin - end
    length = np.concatenate([left, 2.0 * cut[corner]])[by_order]
    curve = np.concatenate([np.arange(count), count + np.arange(len(corner))])[by_order]
    offset = np.concatenate([begin, np.zeros(len(corner))])[by_order]
    speed = np.concatenate([course.speed, slow[corner]])[by_order]
    # A piece that its corners have used up is none; its chain goes on with the next corner.
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
    """Return which shares of acceleration and jerk changes of speed may take in sections, (M,), 1 in straight ones."""
    straight = used.bounds[:, 1] == 0.0
    share = np.where(straight, 1.0, np.where(path.curve < pieces, ROUND, AROUND))
    # Zones of sections that are all straight or all not; of the latter those are alone that lie between lines which are
    # long enough for any change of speed before and after them.
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
    """Return acceleration and jerk along the path, (N,) each, of shares (N,) that are 1 where it is straight."""
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
    """Make the trajectory of phases (P, 5) of chains (P,) that begin at times (P,), s."""
    phase, begin = _parts(path.starts, phases)
    following = np.concatenate([phase[1:] == phase[:-1], [False]])
    end = np.where(following, np.concatenate([begin[1:], [0.0]]), phases[phase, 0])
    long = end - begin > SHORTEST
    phase, begin, end = phase[long], begin[long], end[long]
    if not len(phase):
        return hold(path.curves.at(path.curve[:1], path.offset[:1])[0][0], orientation)
    middle = phases[phase, 1] + _state(phases[phase], 0.5 * (begin + end))[0]
    section = np.searchsorted(path.starts, middle, side="right") - 1
    # Near a stop rounding may put it into the next chain, which goes another way.
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
    # Straight parts are cubics.
    found = np.stack([x, v * h, 0.5 * a * h**2, d * phases[:, 4:] * h**3 / 6.0, none, none], axis=2).reshape(-1, 18)
    bent = np.flatnonzero(path.curves.bounds[curve, 1] > 0.0)
    curve, s, share, v0, a0, phases = curve[bent], s[bent], share[bent], v0[bent], a0[bent], phases[bent]
    h, x, v, a = h[bent], x[bent], v[bent], a[bent]
    ds = share * (v0 + share * (0.5 * a0 + share * phases[:, 4] / 6.0))
    _, v1, a1 = _state(phases, first[bent] + share)
    _, d1, dd1 = path.curves.at(curve, s + ds)
    end = d1 * a1[:, None] + dd1 * v1[:, None] ** 2
    made = quintic(h, x, path.curves.way(curve, s, ds), v, d1 * v1[:, None], a, end)
    brief = JERK_EXACT * jerk * share**2 < ROUNDING * v0
    level = np.stack([x, v * h, 0.5 * a * h**2, (end - a) * h**2 / 6.0, 0.0 * x, 0.0 * x], axis=2).reshape(-1, 18)
    found[bent] = np.where(brief[:, None], level, made)
    return found


def _parts(starts: Array, phases: Array) -> tuple[Indices, Array]:
    """Divide phases where sections end: the phase of each part, in order, and when it begins in it, s."""
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
    """Return of how many quintics each part is made.

    Of Hermite interpolation's error the largest is h^6 max|p^(6)| / 46080, and that of its third derivative, at both
    ends, h^3 max|p^(6)| / 120, here taken twice; the sixth derivative of q(s(t)) is bounded by Faa di Bruno's formula,
    with s'''' = 0.
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
