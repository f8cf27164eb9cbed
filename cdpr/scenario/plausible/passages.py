"""Passages of moving points by fixed points and lines, found continuously along a motion, not only at samples.

The Bernstein coefficients of a segment's polynomials bound the speed of a point of the platform. Intervals in which
that speed is too low to come near are dropped; all others are bisected until they are short. So no passage is missed
between samples.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.base.tolerances import HELD
from cdpr.model.robot import Array

# Share of a cable's largest distance from its anchor during the motion below which it passes the anchor. Controllers
# have tracking errors of this size, and a cable this short turns by degrees within a control step.
NEAR = 1e-3
FINE = 0.5  # largest travel of a point in the shortest intervals, as a share of that distance
SAMPLES, REFINEMENTS = 9, 8  # for the closest interval: down to 4^-8 of its width
SIDES = 33  # places near an axis at which sides are compared

# Value of the derivative of a quintic sum(c_j s^j): Bernstein coefficients (5,) of a quartic from c_1 to c_5.
_BERNSTEIN = np.array(
    [[1, 0, 0, 0, 0], [1, 1 / 4, 0, 0, 0], [1, 1 / 2, 1 / 6, 0, 0], [1, 3 / 4, 1 / 2, 1 / 4, 0], [1.0] * 5]
)
_RATES = _BERNSTEIN * np.arange(1.0, 6.0)


class Passage(NamedTuple):
    """Closest approach of a cable's end to its anchor, or to the axis through it."""

    cable: int  # index
    time: float  # s
    distance: float  # m
    axis: bool  # True if the axis is passed


def passages(segments: Array, anchors: Array, axes: Array, end: float = np.inf) -> list[Passage]:
    """Return the passages of a motion until `end` (s) in the order of time.

    A cable passes its anchor if it is shorter than NEAR of its largest length. A cable with an axis passes the axis if
    it comes as near to it and reaches the other side; motions along the axis are no passages.

    Args:
        segments: (K, 42), of a `Trajectory`.
        anchors: (m, 6), on the frame, world, and on the platform, platform axes, m.
        axes: (m, 3), unit vectors of lines through the frame anchors; zeros if there is none.
        end: end time, s.
    """
    tips = _Tips(segments[segments[:, 0] < end] if (segments[:, 0] < end).any() else segments[:1], anchors, axes)
    found = []
    for i, low, high, at, width in tips.near():
        place, distance = tips.closest(i, at, width)
        time = tips.time(place)
        axis = bool(axes[i].any())
        if time <= end and (not axis or tips.crossed(i, low, high)):
            found.append(Passage(i, time, distance, axis))
    return sorted(found, key=lambda one: one.time)


class _Tips:
    """Platform ends of cables along a motion; a place is the index of a segment plus a share of it."""

    def __init__(self, segments: Array, anchors: Array, axes: Array) -> None:
        self.segments, self.anchors, self.axes = segments, anchors, axes
        position, turn = (segments[:, at : at + 18].reshape(-1, 3, 6) for at in (2, 20))
        # Bounds of the speeds (K,) per share: |omega| is at most the rate of the rotation vector.
        moved, turned = (np.linalg.norm(c[..., 1:] @ _RATES.T, axis=1).max(axis=1) for c in (position, turn))
        self.speed = moved[:, None] + turned[:, None] * np.linalg.norm(anchors[:, 3:], axis=1)
        self.position, self.turn = position, turn

    def time(self, at: float) -> float:
        k = min(int(at), len(self.segments) - 1)
        return float(self.segments[k, 0] + (at - k) * self.segments[k, 1])

    def offset(self, k: NDArray[np.intp], s: Array, i: NDArray[np.intp], whole: bool = False) -> Array:
        """Return the vectors from anchors to the ends of cables i at shares s of segments k, square to the axes."""
        powers = s[:, None] ** np.arange(6)
        p, phi = (np.einsum("nij,nj->ni", c[k], powers) for c in (self.position, self.turn))
        b = self.anchors[i, 3:]
        angle = np.linalg.norm(phi, axis=1)[:, None]
        half = 0.5 * angle
        q = np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * phi], axis=1)
        d = p + _rotate(self.segments[k, 38:], _rotate(q, b)) - self.anchors[i, :3]
        axis = np.zeros_like(d) if whole else self.axes[i]
        return np.asarray(d - np.sum(d * axis, axis=1)[:, None] * axis)

    def near(self) -> list[tuple[int, float, float, float, float]]:
        """Return cable, first and last place, and place and width of the closest interval for each approach."""
        count, m = self.speed.shape
        k, i = (index.ravel() for index in np.indices((count, m)))
        ends = [np.linalg.norm(self.offset(k, np.full(len(k), s), i, whole=True), axis=1) for s in (0.0, 0.5, 1.0)]
        near = HELD + NEAR * np.max(ends, axis=0).reshape(count, m).max(axis=0)
        s, h = np.full(len(k), 0.5), 1.0
        leaves: list[tuple[int, float, float, float]] = []
        while len(k):
            d = np.linalg.norm(self.offset(k, s, i), axis=1)
            far = 0.5 * h * self.speed[k, i]
            left = d - far <= near[i]
            fine = left & (far <= FINE * near[i])
            for j in np.flatnonzero(fine & (d <= near[i])):
                leaves.append((int(i[j]), k[j] + s[j] - 0.5 * h, k[j] + s[j] + 0.5 * h, float(d[j])))
            left &= ~fine
            h *= 0.5
            k, i = np.tile(k[left], 2), np.tile(i[left], 2)
            s = np.concatenate([s[left] - 0.5 * h, s[left] + 0.5 * h])
        return _joined(leaves)

    def closest(self, i: int, at: float, width: float) -> tuple[float, float]:
        """Return place and distance, m, of the closest approach of cable i within a width on both sides of a place."""
        count, d = len(self.segments), np.inf
        for _ in range(REFINEMENTS):
            places = np.clip(np.linspace(at - width, at + width, SAMPLES), 0.0, count)
            k = np.minimum(places.astype(np.intp), count - 1)
            each = np.linalg.norm(self.offset(k, places - k, np.full(SAMPLES, i)), axis=1)
            at, d = float(places[each.argmin()]), float(each.min())
            width *= 2.0 / (SAMPLES - 1)
        return at, d

    def crossed(self, i: int, low: float, high: float) -> bool:
        """Return True if cable i is on both sides of its axis between two places near it.

        Many places are compared: a motion may end directly behind the axis, or return to the side from which it came.
        """
        count = len(self.segments)
        places = np.clip(np.linspace(low, high, SIDES), 0.0, count)
        k = np.minimum(places.astype(np.intp), count - 1)
        offset = self.offset(k, places - k, np.full(SIDES, i))
        offset = offset[np.linalg.norm(offset, axis=1) > HELD]
        return bool((offset @ offset.T < 0.0).any())


def _joined(leaves: list[tuple[int, float, float, float]]) -> list[tuple[int, float, float, float, float]]:
    """Join adjacent intervals."""
    out: list[tuple[int, float, float, float, float]] = []
    least = np.inf
    for i, low, high, d in sorted(leaves):
        at = 0.5 * (low + high)
        if out and out[-1][0] == i and low - out[-1][2] <= 1.5 * (high - low):
            first, place, width = out[-1][1], out[-1][3], out[-1][4]
            out[-1] = (i, first, high, *((at, high - low) if d < least else (place, width)))
            least = min(d, least)
        else:
            out.append((i, low, high, at, high - low))
            least = d
    return out


def _rotate(q: Array, v: Array) -> Array:
    """Rotate vectors (n, 3) by quaternions (n, 4)."""
    t = 2.0 * np.cross(q[:, 1:], v)
    return np.asarray(v + q[:, :1] * t + np.cross(q[:, 1:], t))
