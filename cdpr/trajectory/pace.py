"""Speed along a path of many sections: compiled, as a path has at least as many sections as its program has lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.model.robot import Array
from cdpr.native.bind import bind

Indices = NDArray[np.int64]


def pace(
    starts: ArrayLike, caps: ArrayLike, accelerations: ArrayLike, jerks: ArrayLike, chains: ArrayLike
) -> tuple[Array, Indices]:
    """Plan each chain of sections from rest to rest, with limited jerk, no section passed faster than its cap.

    A stretch is planned at the least cap of its sections. Where that is reached, the section that it belongs to is
    passed at it, and what lies before and after is planned anew, without this section: its caps are higher. So no
    speed is above a cap by construction, and each step ends with one section less.

    Args:
        starts: (N + 1,) m, the beginning of each section, and the end of the last one; increasing.
        caps: (N,) m/s, the largest speed in each.
        accelerations: (N,) m/s^2, the largest along the path in each.
        jerks: (N,) m/s^3, likewise; both are least in the same section.
        chains: (C + 1,) the first section of each chain, and N; each has one or more.

    Returns:
        Phases (P, 5): duration, s; place, m; speed, m/s, and acceleration, m/s^2, at the beginning; jerk, m/s^3. The
        first phase of each chain, and P, (C + 1,).

    Raises:
        ValueError: The shapes do not match, or the chains are not those of N sections.

    Example:
        >>> phases, rows = pace([0.0, 1.0], [0.5], [2.0], [20.0], [0, 1])
        >>> float(phases[:, 0].sum()), rows
        (2.35, array([0, 7]))
    """
    given = {"starts": starts, "caps": caps, "accelerations": accelerations, "jerks": jerks}
    arrays = {name: np.ascontiguousarray(value, dtype=np.float64) for name, value in given.items()}
    first = np.ascontiguousarray(chains, dtype=np.int64)
    sections = arrays["caps"].size
    if first.ndim != 1 or first.size < 2 or first[0] != 0 or first[-1] != sections or (np.diff(first) < 1).any():
        raise ValueError(f"pace: chains: expected increasing numbers from 0 to {sections}, 2 or more, got {first}.")
    count = len(first) - 1
    phases, rows = np.empty((8 * sections + 7 * count, 5)), np.empty(count + 1, dtype=np.int64)
    bind("pace", **arrays, chains=first, phases=phases, rows=rows, c=count)()
    return phases[: rows[-1]].copy(), rows
