"""How near cables come to each other, to their platform and to obstacles along a motion, in pieces of any size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.mechanics.clearance import Clearance
from cdpr.model.robot import Array

PIECE = 4096  # rows that are looked at together


@dataclass(frozen=True)
class Level:
    """A clearance of which is told where it is reached."""

    clearance: float  # m
    after: float = 0.0  # s, from when on


@dataclass(frozen=True)
class Near:
    """The least clearance of some samples."""

    clearance: float  # m
    time: float  # s
    which: int  # for `Clearance.name`


@dataclass(frozen=True)
class Span:
    """Samples, one after the other, at a level or below it."""

    first: Near
    least: Near
    until: float  # s, the last of them
    samples: int


class Closest:
    """Looks at samples as they come.

    A cable that is `broken`, from a time (s) on, is no more. Poses that are not finite have no clearance.

    Args:
        among: who may touch whom.
        broken: which cables, counted from 0, and since when.
        levels: of which spans are kept.

    Attributes:
        least: of all samples so far; None where there is none, or nothing that may touch.
    """

    def __init__(
        self, among: Clearance, broken: Sequence[tuple[int, float]] = (), levels: Sequence[Level] = ()
    ) -> None:
        self._among, self._broken = among, tuple(broken)
        self._spans: list[tuple[Level, list[Span], bool]] = [(level, [], False) for level in levels]
        self.least: Near | None = None

    @property
    def levels(self) -> tuple[Level, ...]:
        """Of which spans are kept."""
        return tuple(level for level, _, _ in self._spans)

    def spans(self, i: int) -> Sequence[Span]:
        """Return those of the i-th level, in the order of time."""
        return self._spans[i][1]

    def name(self, near: Near) -> str:
        """Return what is nearest to what."""
        return self._among.name(near.which)

    def lose(self, broken: Sequence[tuple[int, float]]) -> None:
        """Go by these cables that break, after the samples that were looked at."""
        self._broken = tuple(broken)

    def copy(self) -> Closest:
        """Return one that goes on by itself."""
        other = copy(self)
        other._spans = [(level, list(spans), open_) for level, spans, open_ in self._spans]
        return other

    def add(self, time: ArrayLike, poses: ArrayLike) -> None:
        """Look at the samples that follow, at times (K,), s, at poses (K, 7)."""
        times, table = np.asarray(time, dtype=float), np.asarray(poses, dtype=float)
        for start in range(0, len(times), PIECE):
            self._add(times[start : start + PIECE], table[start : start + PIECE])

    def _add(self, time: Array, poses: Array) -> None:
        clearance, which = self._look(time, poses)
        k = int(np.argmin(clearance))
        if clearance[k] < (math.inf if self.least is None else self.least.clearance):
            self.least = Near(float(clearance[k]), float(time[k]), int(which[k]))
        for i, (level, spans, _) in enumerate(self._spans):
            under = (clearance <= level.clearance) & (time >= level.after)
            edges = np.flatnonzero(np.diff(under, prepend=False, append=False)).reshape(-1, 2).tolist()
            for start, stop in edges:
                low = start + int(np.argmin(clearance[start:stop]))
                first, least = (Near(float(clearance[j]), float(time[j]), int(which[j])) for j in (start, low))
                span = Span(first, least, float(time[stop - 1]), stop - start)
                if start == 0 and self._spans[i][2]:
                    span = _joined(spans.pop(), span)
                spans.append(span)
            self._spans[i] = level, spans, bool(under[-1])

    def _look(self, time: Array, poses: Array) -> tuple[Array, NDArray[np.int64]]:
        """Clearances (K,), m, infinite where there is none, and of what."""
        clearance, which = np.full(len(time), math.inf), np.full(len(time), -1, dtype=np.int64)
        sound = np.isfinite(poses).all(axis=1)
        cuts = sorted({-math.inf, *(since for _, since in self._broken)})
        for since, until in zip(cuts, [*cuts[1:], math.inf], strict=True):
            now = np.flatnonzero(sound & (time >= since) & (time < until))
            if len(now):
                gone = [cable for cable, at in self._broken if at <= since]
                among = self._among.without(gone) if gone else self._among
                clearance[now], which[now] = among.at(poses[now], jobs=1)
        return clearance, which


def _joined(before: Span, after: Span) -> Span:
    """One span of two, one right after the other."""
    least = min(before.least, after.least, key=lambda near: near.clearance)
    return replace(before, least=least, until=after.until, samples=before.samples + after.samples)
