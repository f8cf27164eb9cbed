"""Region of a workspace: a box of positions divided into cells, and the attitudes of the platform."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.base import tolerances
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import DOF_NAMES, Array, read_only
from cdpr.model.rotations import held_upright
from cdpr.native.arrays import MASKED, masked, real

CELLS = 40  # default along the longest side
MOST_CELLS = 10**9  # limit of a table in memory
MOST_NUMBERED = 10**15  # limit of cells in chunks
FARTHEST = 1e9  # m; beyond, positions are coarser than 0.1 um
PIECE = 65536  # poses per batch


@dataclass(frozen=True, eq=False)
class Region:
    """Box divided into cells, which are evaluated at their centres.

    Attributes:
        lower, upper: corners, (3,), m, world; equal along held directions.
        shape: cells along x, y, z.
        orientations: (k, 4), quaternions w, x, y, z.
    """

    lower: Array
    upper: Array
    shape: tuple[int, int, int]
    orientations: Array

    @property
    def cells(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    @property
    def moving(self) -> list[int]:
        """Axes along which the box has an extent."""
        return [i for i in range(3) if self.upper[i] > self.lower[i]]

    @property
    def cell(self) -> float:
        """Size of a cell: m^3, or m^2 or m for motion in a plane or along a line."""
        return float(np.prod(self.spacing[self.moving]))

    @property
    def spacing(self) -> Array:
        """Sides of a cell, (3,), m."""
        return np.asarray((self.upper - self.lower) / self.shape)

    @property
    def unit(self) -> str:
        """Unit of that size."""
        return ("", "m", "m^2", "m^3")[len(self.moving)]

    @cached_property
    def axes(self) -> tuple[Array, Array, Array]:
        """Centres of the cells along each axis, m."""
        x, y, z = (
            low + (np.arange(n) + 0.5) * ((high - low) / n)
            for low, high, n in zip(self.lower, self.upper, self.shape, strict=True)
        )
        return x, y, z

    def positions(self, cells: NDArray[np.int64]) -> Array:
        """Return the centres of the cells with these numbers, (n, 3), the last axis fastest."""
        index = np.unravel_index(cells, self.shape)
        return np.stack([axis[i] for axis, i in zip(self.axes, index, strict=True)], axis=1)

    def pieces(self) -> Iterator[NDArray[np.int64]]:
        """Yield the numbers of cells in batches."""
        for first in range(0, self.cells, PIECE):
            yield np.arange(first, min(first + PIECE, self.cells))


def region(
    robot: Robot,
    *,
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
    cells: int | Sequence[int] | None = None,
    orientations: ArrayLike | None = None,
) -> Region:
    """Return the region of a robot's workspace.

    Args:
        robot: robot, whose held directions have no extent.
        lower: lowest corner of the box, (3,), m; by default that of the frame's outline, or of the box around all
            frame anchors and the plane z = 0. If these have no extent along an axis, half the largest extent is added
            on either side.
        upper: highest corner of the box, likewise.
        cells: cells along x, y, z, or along the longest side.
        orientations: (4,) or (k, 4), unit quaternions w, x, y, z; that of home by default.

    Raises:
        CdprError: if a number is invalid.
    """
    home = home_pose(robot)[0]
    edges = robot.frame.edges if robot.frame is not None else robot.anchors[:, :3]
    ends = edges.reshape(-1, 3)
    floor = [] if robot.frame is not None else [np.array([ends[0, 0], ends[0, 1], 0.0])]
    low = np.min([*ends, *floor], axis=0) if lower is None else checked(lower, (3,), "lower", finite=True).copy()
    high = np.max([*ends, *floor], axis=0) if upper is None else checked(upper, (3,), "upper", finite=True).copy()
    widest = float((high - low).max())
    for i, name in enumerate(DOF_NAMES[:3]):
        if lower is None and upper is None and low[i] == high[i]:  # anchors in a plane: space below and above it
            low[i], high[i] = low[i] - 0.5 * widest, high[i] + 0.5 * widest
        if name not in robot.dof:
            low[i] = high[i] = home[i]
        elif not low[i] < high[i]:
            raise CdprError(f"box: {name} of lower, {low[i]:g} m, must be below that of upper, {high[i]:g} m")
    if not np.abs([low, high]).max() <= FARTHEST:
        raise CdprError(f"box: its corners must be within {FARTHEST:g} m")
    extent = high - low
    if not extent.any():
        raise CdprError(f"robot: '{robot.name}' does not change its position, so it has no workspace of positions")
    turned = home[None, 3:] if orientations is None else np.atleast_2d(checked_quaternions(orientations))
    for q in turned:
        if not held_upright(robot.dof, q):
            raise CdprError(
                f"orientations: the robot moves along {', '.join(robot.dof)} only, so it cannot rotate about the "
                "other axes"
            )
    shape = _shape(cells, extent)
    return Region(read_only(low), read_only(high), shape, read_only(turned.copy()))


def checked_quaternions(given: ArrayLike) -> Array:
    """Return unit quaternions (k, 4).

    Raises:
        CdprError: if they are invalid.
    """
    found = np.atleast_2d(real(given, "orientations"))
    found = checked(found, (None, 4), "orientations", finite=True)
    lengths = np.linalg.norm(found, axis=1)
    if not len(found) or np.abs(lengths - 1.0).max() > tolerances.UNIT:
        raise CdprError("orientations: expected unit quaternions w, x, y, z")
    return np.asarray(found / lengths[:, None])


def _shape(cells: int | Sequence[int] | None, extent: Array) -> tuple[int, int, int]:
    """Return the number of cells along x, y, z."""
    if masked(cells):
        raise CdprError(f"cells: {MASKED}")
    try:
        several = np.atleast_1d(CELLS if cells is None else cells)
    except Exception:  # of a foreign class, or a list that contains itself
        several = np.empty(0)
    if several.shape not in ((1,), (3,)) or several.dtype.kind not in "iu" or several.min() < 1:
        raise CdprError(f"cells: expected one or three whole numbers from 1 on, got {shown(cells)}")
    counts = [int(n) for n in several]
    if len(counts) == 1:
        counts = [max(1, round(counts[0] * side / extent.max())) for side in extent.tolist()]
    counts = [n if side else 1 for n, side in zip(counts, extent.tolist(), strict=True)]
    if math.prod(counts) > MOST_NUMBERED:
        raise CdprError(f"cells: {math.prod(counts)} cells are too many; at most {MOST_NUMBERED} are allowed")
    return counts[0], counts[1], counts[2]
