"""Compiled speed profile along a path of many sections; a path has at least as many as its program has lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.model.robot import Array
from cdpr.native.arrays import reals, whole
from cdpr.native.bind import bind

Indices = NDArray[np.int64]


def pace(
    starts: ArrayLike, caps: ArrayLike, accelerations: ArrayLike, jerks: ArrayLike, chains: ArrayLike
) -> tuple[Array, Indices]:
    """Plan each chain of sections from rest to rest, with limited jerk and no section passed faster than its cap.

    A stretch is planned with the smallest cap of its sections. If the profile reaches that cap, its section is passed
    at it. The parts before and after are then planned again without this section, with higher caps. So no speed exceeds
    a cap, and each step removes one section.

    Args:
        starts: (N + 1,) m, the beginning of each section and the end of the last one; increasing.
        caps: (N,) m/s, the largest speed in each.
        accelerations: (N,) m/s^2, the largest along the path in each.
        jerks: (N,) m/s^3, likewise; both are smallest in the same section.
        chains: (C + 1,) the first section of each chain, and N; each has one or more.

    Returns:
        Phases (P, 5): duration, s; position, m; speed, m/s, and acceleration, m/s^2, at the beginning; jerk, m/s^3. The
            first phase of each chain, and P, (C + 1,).

    Raises:
        ValueError: if the shapes do not match, or the chains are not those of N sections.

    Example:
        >>> phases, rows = pace([0.0, 1.0], [0.5], [2.0], [20.0], [0, 1])
        >>> float(phases[:, 0].sum()), rows
        (2.35, array([0, 7]))
    """
    arrays = reals(starts=starts, caps=caps, accelerations=accelerations, jerks=jerks)
    first = whole(chains, "chains")
    sections = arrays["caps"].size
    if first.ndim != 1 or first.size < 2 or first[0] != 0 or first[-1] != sections or (np.diff(first) < 1).any():
        raise ValueError(f"pace: chains: expected increasing numbers from 0 to {sections}, 2 or more, got {first}.")
    count = len(first) - 1
    phases, rows = np.empty((8 * sections + 7 * count, 5)), np.empty(count + 1, dtype=np.int64)
    bind("pace", **arrays, chains=first, phases=phases, rows=rows, c=count)()
    return phases[: rows[-1]].copy(), rows
