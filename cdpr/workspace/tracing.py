"""Where along rays a clearance is above an edge: compiled.

A clearance changes by no more than the platform moves, so that from where it is c nothing changes within c: a ray is
gone along in such steps (sphere tracing: Hart, Visual Computer 12, 1996), and where its sign does change the place is
bisected. That is so of all bodies alike, thick cables or solids. What is missed is shorter than `SHORT`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.mechanics import clearance
from cdpr.model.jit import kernel, threaded_kernel
from cdpr.model.kinds import INDICES, NOTHING, NUMBER, ROW, TABLE, TRUTH, WHOLE, Group
from cdpr.model.robot import Array

SHORT = 1e-6  # m: free or blocked stretches that are shorter may be missed
HALVINGS = 40  # of a step, a metre at most, to a billionth of a millimetre
MOST = 64  # ends of intervals along one ray


class Search(NamedTuple):
    """Rays along an axis, and what is found."""

    axis: int
    over_all: bool  # whether all attitudes count, or one is enough
    low: float  # m, where all begin
    high: float
    edge: float  # m, the clearance between free and blocked
    positions: Array  # (K, 3), m, of the rays' beginnings
    orientations: Array  # (k, 4)
    ends: Array  # (K, MOST), m, where free stretches begin and end
    counts: NDArray[np.int64]  # (K,), of these


SEARCH = Group((WHOLE, TRUTH, NUMBER, NUMBER, NUMBER, TABLE, TABLE, TABLE, INDICES), Search)


@kernel
def value(bodies: clearance.Bodies, asked: Search, at: float, pose: Array, ends: Array) -> float:
    """Return the clearance at a place of a ray, whose pose is given but for that, less the edge."""
    pose[asked.axis] = at
    found = 0.0
    for k in range(asked.orientations.shape[0]):
        for i in range(4):
            pose[3 + i] = asked.orientations[k, i]
        here, _ = clearance.nearest(bodies, pose, ends)
        if k == 0 or (here < found) == asked.over_all:
            found = here
    return found - asked.edge


@threaded_kernel(NOTHING(clearance.BODIES, SEARCH, TABLE, ROW))
def search(bodies: clearance.Bodies, asked: Search, ends: Array, pose: Array) -> None:
    """Write where free stretches of all rays begin and end, and their numbers; -1 of a ray with too many."""
    for ray in range(asked.positions.shape[0]):
        for i in range(3):
            pose[i] = asked.positions[ray, i]
        count, at = 0, asked.low
        here = value(bodies, asked, at, pose, ends)
        if here > 0.0:
            asked.ends[ray, 0], count = at, 1
        while at < asked.high and count < MOST - 1:
            ahead = min(at + max(abs(here), SHORT), asked.high)
            there = value(bodies, asked, ahead, pose, ends)
            if (there > 0.0) != (here > 0.0):
                low, high = at, ahead
                for _ in range(HALVINGS):
                    middle = 0.5 * (low + high)
                    if (value(bodies, asked, middle, pose, ends) > 0.0) == (here > 0.0):
                        low = middle
                    else:
                        high = middle
                asked.ends[ray, count] = low if here > 0.0 else high
                count += 1
            at, here = ahead, there
        if count % 2 == 1:
            asked.ends[ray, count] = asked.high
            count += 1
        asked.counts[ray] = count if at >= asked.high else -1
