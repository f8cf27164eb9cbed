"""Least clearances of cables along a motion, computed from pieces of any size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.mechanics.clearance import Clearance
from cdpr.model.robot import Array

PIECE = 4096  # rows per batch


@dataclass(frozen=True)
class Level:
    """Clearance at or below which spans of samples are recorded."""

    clearance: float  # [m]
    after: float = 0.0  # start of the recording [s]


@dataclass(frozen=True)
class LeastClearance:
    """Least clearance of some samples."""

    clearance: float  # [m]
    time: float  # [s]
    which: int  # index of the closest pair for `Clearance.name`


@dataclass(frozen=True)
class Span:
    """Consecutive samples at or below a level."""

    first: LeastClearance
    least: LeastClearance
    until: float  # time of the last sample [s]
    samples: int


class Closest:
    """Recorder of the least clearances of a sequence of samples.

    A `broken` cable is left out from its time of breaking [s] on. Poses that are not finite have an infinite clearance.

    Args:
        among: clearances of the robot.
        broken: numbers of the broken cables, from 0, and the times at which they break [s].
        levels: levels for which spans are recorded.

    Attributes:
        least: least clearance of all samples so far, None if there is none or if nothing can touch.
    """

    def __init__(
        self, among: Clearance, broken: Sequence[tuple[int, float]] = (), levels: Sequence[Level] = ()
    ) -> None:
        self._among, self._broken = among, tuple(broken)
        self._spans: list[tuple[Level, list[Span], bool]] = [(level, [], False) for level in levels]
        self.least: LeastClearance | None = None

    @property
    def levels(self) -> tuple[Level, ...]:
        """Levels for which spans are recorded."""
        return tuple(level for level, _, _ in self._spans)

    def spans(self, i: int) -> Sequence[Span]:
        """Return the spans of level i in the order of time."""
        return self._spans[i][1]

    def name(self, near: LeastClearance) -> str:
        """Return the names of the closest pair."""
        return self._among.name(near.which)

    def lose(self, broken: Sequence[tuple[int, float]]) -> None:
        """Replace the broken cables for the samples that follow."""
        self._broken = tuple(broken)

    def copy(self) -> Closest:
        """Return an independent copy."""
        other = copy(self)
        other._spans = [(level, list(spans), open_) for level, spans, open_ in self._spans]
        return other

    def add(self, time: ArrayLike, poses: ArrayLike, unwound: ArrayLike | None = None) -> None:
        """Add the samples that follow.

        Args:
            time: (K,) s.
            poses: (K, 7) positions [m] and quaternions w, x, y, z.
            unwound: (K, m) unwound lengths [m], for the curves of cables that sag; None if unknown.
        """
        times, table = np.asarray(time, dtype=float), np.asarray(poses, dtype=float)
        lengths = None if unwound is None else np.asarray(unwound, dtype=float)
        for start in range(0, len(times), PIECE):
            cut = slice(start, start + PIECE)
            self._add(times[cut], table[cut], None if lengths is None else lengths[cut])

    def _add(self, time: Array, poses: Array, unwound: Array | None) -> None:
        clearance, which = self._evaluate(time, poses, unwound)
        k = int(np.argmin(clearance))
        if clearance[k] < (math.inf if self.least is None else self.least.clearance):
            self.least = LeastClearance(float(clearance[k]), float(time[k]), int(which[k]))
        for i, (level, spans, _) in enumerate(self._spans):
            under = (clearance <= level.clearance) & (time >= level.after)
            edges = np.flatnonzero(np.diff(under, prepend=False, append=False)).reshape(-1, 2).tolist()
            for start, stop in edges:
                low = start + int(np.argmin(clearance[start:stop]))
                first, least = (
                    LeastClearance(float(clearance[j]), float(time[j]), int(which[j])) for j in (start, low)
                )
                span = Span(first, least, float(time[stop - 1]), stop - start)
                if start == 0 and self._spans[i][2]:
                    span = _joined(spans.pop(), span)
                spans.append(span)
            self._spans[i] = level, spans, bool(under[-1])

    def _evaluate(self, time: Array, poses: Array, unwound: Array | None) -> tuple[Array, NDArray[np.int64]]:
        """Return the clearances (K,) [m], infinite if there is none, and the indices of the closest pairs."""
        clearance, which = np.full(len(time), math.inf), np.full(len(time), -1, dtype=np.int64)
        sound = np.isfinite(poses).all(axis=1)
        cuts = sorted({-math.inf, *(since for _, since in self._broken)})
        for since, until in zip(cuts, [*cuts[1:], math.inf], strict=True):
            now = np.flatnonzero(sound & (time >= since) & (time < until))
            if len(now):
                gone = [cable for cable, at in self._broken if at <= since]
                among = self._among.without(gone) if gone else self._among
                lengths = None if unwound is None else unwound[now]
                clearance[now], which[now] = among.at(poses[now], jobs=1, unwound=lengths)
        return clearance, which


def _joined(before: Span, after: Span) -> Span:
    """Return the union of two spans, the second directly after the first."""
    least = min(before.least, after.least, key=lambda near: near.clearance)
    return replace(before, least=least, until=after.until, samples=before.samples + after.samples)
