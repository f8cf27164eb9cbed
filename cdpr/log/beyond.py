"""Where cables leave their limits: of length and speed, and where others are believed, of tension."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cdpr.log.layout import Layout
from cdpr.mechanics.reach import EXCEEDED, Bounds, Exceeded, Reach
from cdpr.model.robot import Array
from cdpr.tension.overdraw import OVERDRAWN, Overdraw

KINDS = (*EXCEEDED, *OVERDRAWN)


class Beyond:
    """Counts the samples of a run as they come, in pieces of any size.

    Args:
        layout: columns of its rows.
        bounds: of the robot's lengths and winding speeds.
        limits: (2, m) lowest and highest tensions, N.
        broken: cables that break, counted from 0, and when, s.

    Attributes:
        any: whether there are limits that can be left.
    """

    def __init__(self, layout: Layout, bounds: Bounds, limits: Array, broken: Sequence[tuple[int, float]]) -> None:
        self._columns = layout.columns
        self._reach = Reach(bounds, limits.shape[1], broken)
        self._overdraw = Overdraw(limits) if "true_margin" in layout.fields else None
        self.any = self._reach.any or self._overdraw is not None

    def lose(self, broken: Sequence[tuple[int, float]]) -> None:
        """Take these cables for broken, each from a time (s) on, and no others."""
        self._reach.lose(broken)

    def add(self, rows: Array) -> bool:
        """Count the samples that follow, (n, width); True where one leaves a limit."""
        at = self._columns
        time = np.ascontiguousarray(rows[:, at["time"]][:, 0])
        left = self._reach.add(time, *(np.ascontiguousarray(rows[:, at[name]]) for name in ("length", "rate")))
        if self._overdraw is not None:
            left |= self._overdraw.add(rows[:, at["tension"]], rows[:, at["true_margin"]])
        return left

    def told(self) -> list[Exceeded]:
        """Return the limits that were left."""
        return [*self._reach.told(), *(self._overdraw.told() if self._overdraw else ())]

    def counts(self) -> dict[str, int]:
        """Return at how many samples each kind of limit that there is was left."""
        kinds = (*(EXCEEDED if self._reach.any else ()), *(OVERDRAWN if self._overdraw else ()))
        return {name: 0 for name, *_ in kinds} | {one.name: one.samples for one in self.told()}
