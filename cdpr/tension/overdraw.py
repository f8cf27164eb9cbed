"""Commands beyond the limits that cables have in truth: where the controller believes in others."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cdpr.mechanics.reach import Exceeded
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.tension.checks import LIMIT_TOLERANCE, newton

# As `cdpr.mechanics.reach.EXCEEDED`.
OVERDRAWN = (("below_min", "cables told to pull less", "N"), ("above_max", "cables told to pull more", "N"))


class Overdraw:
    """Counts where commands leave the true limits (2, m), N, in pieces of any size.

    `limits` are those at first: where an event changes them, it changes what is believed to the same, and nothing is
    beyond them.
    """

    def __init__(self, limits: Array) -> None:
        self.limits, m = limits, limits.shape[1]
        self._least = -LIMIT_TOLERANCE * newton(limits)
        self._worst = np.zeros((2, m))  # by how much, N
        self._samples = np.zeros(2, int)
        self._first = np.zeros(2, int)
        self.counted = 0

    def add(self, tension: Array, room: Array) -> bool:
        """Count the samples that follow: commands, N, their `true_margin`, N, both (n, m); True where one leaves."""
        beyond = room < self._least  # false for NaN
        self.counted += len(tension)
        if not beyond.any():
            return False
        for i, side in enumerate((beyond & (tension < self.limits[0]), beyond & (tension > self.limits[1]))):
            found = np.flatnonzero(side.any(axis=1))
            if found.size:
                if not self._samples[i]:
                    self._first[i] = self.counted - len(tension) + found[0]
                self._samples[i] += found.size
                np.maximum(self._worst[i], np.where(side, -room, 0.0).max(axis=0), out=self._worst[i])
        return True

    def told(self) -> Iterator[Exceeded]:
        """Yield the limits that were left."""
        for i, (name, words, unit) in enumerate(OVERDRAWN):
            if self._samples[i]:
                worst = self._worst[i]
                cables = tuple(int(j) for j in np.argsort(-worst, kind="stable") if worst[j] > 0.0)
                limit = float(self.limits[i, cables[0]])
                value = limit + float(worst[cables[0]]) * (-1.0 if i == 0 else 1.0)
                first, samples = int(self._first[i]), int(self._samples[i])
                yield Exceeded(name, words, cables, first, samples, value, limit, unit)


@kernel
def true_margin(limits: Array, tension: Array, held: Array, room: Array) -> None:
    """Write how far the tensions (m,) are from the nearer of the limits (2, m), N, negative beyond.

    NaN for cables whose `held` (m,) is not: broken or jammed, nothing is asked of them.
    """
    for i in range(tension.shape[0]):
        room[i] = min(tension[i] - limits[0, i], limits[1, i] - tension[i]) if math.isnan(held[i]) else math.nan
