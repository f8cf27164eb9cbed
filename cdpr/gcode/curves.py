"""Pieces of a path: lines, arcs (including helices and spirals), and polynomials that round corners.

Each piece is q(s), (3,) m, with s from 0 to its length: a quintic in w = s / length plus a rotating radius, whose
length and angle are linear in w. |q'(s)| is at most 1 for lines and arcs, and exactly 1 unless they are spirals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array
from cdpr.trajectory.knots import quintic

Indices = NDArray[np.int64]

PLACES = (
    16  # intervals of a corner's polynomial for sampling, including the middle, where a symmetric corner is farthest
)
# The norm of a polynomial of degree n exceeds its samples by about (n / PLACES)^2 / 8 of itself.
MISSED, VARIED = 1.01, 1.5

STRAIGHT = 1e-9  # rad; cubics with a smaller change of direction are lines


@dataclass(frozen=True, eq=False)
class Curves:
    """N pieces.

    Attributes:
        length: range of s, m, (N,).
        powers: coefficients of the quintic in w, lowest power first, m, (N, 3, 6).
        side: (N, 2, 3) unit vectors: direction of the radius at the beginning, and the perpendicular towards which it
            turns; zero if none turns.
        radii: radii at the beginning and end, m, (N, 2).
        angle: rotation angle of the radius, rad, (N,).
        bounds: largest norms of the first to sixth derivative of q by s, (N, 6).
        skew: largest |q' . q''| and |q'' . q'''| as shares of the bounds, (N, 2); 0 if perpendicular.
    """

    length: Array
    powers: Array
    side: Array
    radii: Array
    angle: Array
    bounds: Array
    skew: Array

    def __len__(self) -> int:
        return len(self.length)

    def take(self, which: Indices | NDArray[np.bool_]) -> Curves:
        """Return some of the pieces."""
        return Curves(*(getattr(self, field.name)[which] for field in fields(self)))

    def replace(self, which: Indices, others: Curves) -> None:
        """Replace some of the pieces."""
        for field in fields(self):
            getattr(self, field.name)[which] = getattr(others, field.name)

    def at(self, which: Indices, s: Array) -> tuple[Array, Array, Array]:
        """Return q, q' and q'' (K, 3) of pieces (K,) at s (K,)."""
        length = self.length[which][:, None]
        w = s[:, None] / length
        c = self.powers[which]
        c0, c1, c2, c3, c4, c5 = (c[:, :, k] for k in range(6))
        x = c0 + w * (c1 + w * (c2 + w * (c3 + w * (c4 + w * c5))))
        d = c1 + w * (2.0 * c2 + w * (3.0 * c3 + w * (4.0 * c4 + w * 5.0 * c5)))
        dd = 2.0 * c2 + w * (6.0 * c3 + w * (12.0 * c4 + w * 20.0 * c5))
        if self.angle.any():
            radius, growth, angle, out, on = self._turned(which, w)
            x = x + radius * out
            d = d + radius * angle * on + growth * out
            dd = dd - radius * angle**2 * out + 2.0 * growth * angle * on
        return x, d / length, dd / length**2

    def third(self, which: Indices, s: Array) -> Array:
        """Return the third derivative (K, 3) of q, of pieces (K,) at s (K,)."""
        length = self.length[which][:, None]
        w, c = s[:, None] / length, self.powers[which]
        radius, growth, angle, out, on = self._turned(which, w)
        third = 6.0 * c[:, :, 3] + w * (24.0 * c[:, :, 4] + w * 60.0 * c[:, :, 5])
        return np.asarray((third - radius * angle**3 * on - 3.0 * growth * angle**2 * out) / length**3)

    def way(self, which: Indices, s: Array, ds: Array) -> Array:
        """Return q(s + ds) - q(s), (K, 3), without cancellation for small ds."""
        length = self.length[which]
        w, dw = (s / length)[:, None], (ds / length)[:, None]
        c, end = self.powers[which], w + dw
        way = np.zeros((len(s), 3))
        ladder = np.ones_like(w)  # sums of products of powers of w and end: (end^k - w^k) / dw
        power = np.ones_like(w)
        for k in range(1, 6):
            way += c[:, :, k] * ladder
            power = power * w
            ladder = ladder * end + power
        radius, growth, angle, out, on = self._turned(which, w)
        half = 0.5 * angle * dw
        # Change of the unit vector along the radius: 2 sin(half) times the tangent in the middle.
        turned = 2.0 * np.sin(half) * (np.cos(half) * on - np.sin(half) * out)
        return np.asarray(dw * (way + growth * (out + turned)) + radius * turned)

    def _turned(self, which: Indices, w: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Return the radius, its derivative by w, the angle, and the radial and tangential unit vectors at w."""
        radii, angle, side = self.radii[which], self.angle[which][:, None], self.side[which]
        growth = radii[:, 1:] - radii[:, :1]
        sine, cosine = np.sin(angle * w), np.cos(angle * w)
        out, on = cosine * side[:, 0] + sine * side[:, 1], cosine * side[:, 1] - sine * side[:, 0]
        return radii[:, :1] + growth * w, growth, angle, out, on


def lines(begin: Array, end: Array) -> Curves:
    """Return straight pieces between points (N, 3), m."""
    count = len(begin)
    powers = np.zeros((count, 3, 6))
    powers[:, :, 0], powers[:, :, 1] = begin, end - begin
    length = np.linalg.norm(end - begin, axis=1)
    bounds = np.zeros((count, 6))
    bounds[:, 0] = 1.0
    still = np.zeros((count, 2, 3)), np.zeros((count, 2)), np.zeros(count)
    return Curves(length, powers, *still, bounds, np.zeros((count, 2)))


def arcs(center: Array, out: Array, on: Array, radii: Array, angle: Array, climb: Array) -> Curves:
    """Return arcs, helices and spirals.

    Args:
        center: (N, 3), m, in the plane of the beginning.
        out: (N, 3), unit vector from it to the beginning.
        on: (N, 3), perpendicular unit vector towards which the radius turns.
        radii: radii at the beginning and end, m, (N, 2).
        angle: rotation angle of the radius, rad, (N,), positive.
        climb: (N, 3), displacement along the axis, m.
    """
    count = len(center)
    powers = np.zeros((count, 3, 6))
    powers[:, :, 0], powers[:, :, 1] = center, climb
    growth, radius = radii[:, 1] - radii[:, 0], radii.max(axis=1)
    length = np.sqrt((radius * angle) ** 2 + growth**2 + np.sum(climb**2, axis=1))
    bounds = np.ones((count, 6))
    for k in range(2, 7):
        bounds[:, k - 1] = np.hypot(radius * angle**k, k * growth * angle ** (k - 1)) / length**k
    skew = np.where(growth == 0.0, 0.0, 1.0)[:, None] * np.ones(2)
    return Curves(length, powers, np.stack([out, on], axis=1), radii, angle, bounds, skew)


def joining(length: Array, begin: Sequence[Array], end: Sequence[Array]) -> Curves:
    """Return quintics of lengths (N,) with the given q, q', q'' (N, 3) at both ends."""
    h = length[:, None]
    powers = quintic(h, begin[0], end[0] - begin[0], begin[1], end[1], begin[2], end[2]).reshape(-1, 3, 6)
    count = len(length)
    bounds = np.zeros((count, 6))
    left = powers
    for order in range(1, 6):
        left = left[:, :, 1:] * np.arange(1, left.shape[2])
        share = np.linspace(0.0, 1.0, PLACES + 1) ** np.arange(left.shape[2])[:, None]
        norms = np.linalg.norm(left @ share, axis=1).max(axis=1)
        # the fourth derivative is linear and the fifth constant, so samples are exact
        bounds[:, order - 1] = norms * (MISSED if order < 4 else 1.0) / length**order
        if order == 1:  # 1 at both ends with small variation
            norms /= length
            bounds[:, 0] = 1.0 + VARIED * np.maximum(norms - 1.0, 0.0)
    still = np.zeros((count, 2, 3)), np.zeros((count, 2)), np.zeros(count)
    return Curves(length, powers, *still, bounds, np.ones((count, 2)))


def cubics(length: Array, begin: Sequence[Array], second: Array, whole: Array) -> Curves:
    """Return cubics of lengths (N,) from q, q', q'' (N, 3) at the beginning and q'' at the end.

    They are lines if the direction changes by less than STRAIGHT over `whole`, the length of the curve that contains
    them.
    """
    count, h = len(length), length[:, None]
    x, d, dd = begin
    size = np.maximum(np.linalg.norm(dd, axis=1), np.linalg.norm(second, axis=1))
    third = (second - dd) / h
    straight = size * whole <= STRAIGHT
    powers, bounds, skew = np.zeros((count, 3, 6)), np.zeros((count, 6)), np.zeros((count, 2))
    powers[:, :, 0], powers[:, :, 1] = x, h * (d + np.where(straight[:, None], h * (dd / 3.0 + second / 6.0), 0.0))
    powers[:, :, 2] = np.where(straight[:, None], 0.0, 0.5 * h**2 * dd)
    powers[:, :, 3] = np.where(straight[:, None], 0.0, h**3 * third / 6.0)
    bounds[:, 1], bounds[:, 2] = np.where(straight, 0.0, size), np.where(straight, 0.0, np.linalg.norm(third, axis=1))
    # Products of polynomials are bounded by their Bernstein coefficients: those of q' are d, middle, end; of q'' dd,
    # second.
    middle, end = d + 0.5 * h * dd, d + 0.5 * h * (dd + second)
    fastest = np.max([np.linalg.norm(each, axis=1) for each in (d, middle, end)], axis=0)
    bounds[:, 0] = np.where(fastest <= 1.0 + STRAIGHT, 1.0, fastest)
    along = [
        np.sum(d * dd, axis=1),
        np.sum(d * second + 2.0 * middle * dd, axis=1) / 3.0,
        np.sum(2.0 * middle * second + end * dd, axis=1) / 3.0,
        np.sum(end * second, axis=1),
    ]
    across = [np.sum(dd * third, axis=1), np.sum(second * third, axis=1)]
    skew[:, 0] = np.abs(along).max(axis=0) / np.where(straight, 1.0, size)
    skew[:, 1] = np.abs(across).max(axis=0) / np.where(bounds[:, 2] > 0.0, size * bounds[:, 2], 1.0)
    still = np.zeros((count, 2, 3)), np.zeros((count, 2)), np.zeros(count)
    return Curves(length, powers, *still, bounds, np.where(straight[:, None], 0.0, np.minimum(skew, 1.0)))


def together(parts: Sequence[Curves]) -> Curves:
    """Return the concatenation of pieces."""
    return Curves(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Curves)))
