"""Label placement: each label takes the candidate position with the least overlap. Lengths in inches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cdpr.model.robot import Array

HALF = 0.075  # half the height of a line of small text
BADGE = 0.1  # radius of a numbered circle
ANGLES = np.radians(np.arange(16) * 22.5 + 45.0)  # the first candidate is at the upper right
RADII = (0.24, 0.36, 0.5, 0.66, 0.84)


class OccupiedArea:
    """Discs covered by labels, dots and the edges of a panel of a given size."""

    def __init__(self, size: Array) -> None:
        self._size = size
        self._centres = np.zeros((0, 2))
        self._radii = np.zeros(0)

    def add(self, centres: Array, radius: float) -> None:
        """Add covered discs with these centres (k, 2)."""
        self._centres = np.concatenate([self._centres, centres])
        self._radii = np.concatenate([self._radii, np.full(len(centres), radius)])

    def cost(self, centres: Array, radius: float) -> float:
        """Return how much discs at these centres (k, 2) overlap covered discs or leave the panel."""
        away = np.linalg.norm(centres[:, None] - self._centres[None], axis=2)
        overlap = float(np.maximum(radius + self._radii - away, 0.0).sum())
        out = np.maximum(np.maximum(radius - centres, centres + radius - self._size), 0.0)
        return overlap + 10.0 * float(out.sum())


def place_badges(taken: OccupiedArea, points: Array) -> Array:
    """Return centres (k, 2) of badges near the points (k, 2)."""
    taken.add(points, 0.05)
    centres = np.zeros_like(points)
    for k, point in enumerate(points):
        offers = [
            (point + radius * np.array([np.cos(angle), np.sin(angle)]), radius) for radius in RADII for angle in ANGLES
        ]
        costs = [taken.cost(centre[None], BADGE) + 0.02 * radius for centre, radius in offers]
        centres[k] = offers[int(np.argmin(costs))][0]
        taken.add(centres[k : k + 1], BADGE)
    return centres


def place_along(taken: OccupiedArea, start: Array, end: Array, width: float) -> tuple[Array, float]:
    """Return the centre (2,) and angle (degrees) of a text of this width on the segment, preferably near an end."""
    length = float(np.linalg.norm(end - start))
    along = (end - start) / max(length, 1e-9)
    spread = np.linspace(-0.5, 0.5, max(int(width / HALF), 2))[:, None] * width * along
    margin = min(0.5 * width + 0.06, 0.5 * length)
    steps = np.linspace(margin, length - margin, 25)
    offers = [start + step * along for step in steps]
    ends = np.minimum(steps - margin, length - margin - steps) / max(length, 1e-9)
    costs = [taken.cost(centre + spread, HALF) + 0.05 * away for centre, away in zip(offers, ends, strict=True)]
    centre = offers[int(np.argmin(costs))]
    taken.add(centre + spread, HALF)
    angle = float(np.degrees(np.arctan2(along[1], along[0])))
    return centre, (angle + 90.0) % 180.0 - 90.0


def spread_out(positions: Sequence[float], least: float, low: float, high: float) -> list[float]:
    """Move positions apart within low..high until they differ by `least`, preserving their order with small shifts."""
    order = sorted(range(len(positions)), key=lambda i: (positions[i], i))
    blocks: list[tuple[list[int], float]] = []  # members and centre
    for i in order:
        members, centre = [i], positions[i]
        while True:
            half = 0.5 * least * (len(members) - 1)
            centre = min(max(centre, low + half), high - half) if high - low > 2.0 * half else 0.5 * (low + high)
            if not blocks or blocks[-1][1] + 0.5 * least * (len(blocks[-1][0]) + 1) <= centre - half:
                break
            before, _ = blocks.pop()
            members = before + members
            centre = float(np.mean([positions[k] for k in members]))
        blocks.append((members, centre))
    out = [0.0] * len(positions)
    for members, centre in blocks:
        for rank, i in enumerate(members):
            out[i] = centre + least * (rank - 0.5 * (len(members) - 1))
    return out
