"""Reachable rotations of a platform at each position, in both directions from its attitude, within a workspace.

Rotations are checked in steps until one is outside, followed by bisection; gaps narrower than a step are missed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.workspace.regions import PIECE, Region
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.model import Robot, rotations
from cdpr.model.robot import Array

ABOUT = ("rx", "ry", "rz")
STEP = np.pi / 36.0  # rad, 5 degrees
HALVINGS = 12  # bisections of a step, to a thousandth of a degree
MOST = np.pi  # rad, in either direction


@dataclass(frozen=True, eq=False)
class Turns:
    """Reachable rotations.

    Attributes:
        about: "rx", "ry" or "rz", world axis through the platform's origin.
        least, most: (nx, ny, nz), rad, at most 0 and at least 0, at inside positions; NaN elsewhere.
        region: region of the cells.
        inside: (nx, ny, nz), True for positions inside without rotation.
    """

    about: str
    least: Array
    most: Array
    region: Region
    inside: NDArray[np.bool_]

    @property
    def volume(self) -> float:
        """Size of the inside without rotation."""
        return float(self.inside.sum()) * self.region.cell

    def figures(self) -> dict[str, Any]:
        """Return its figures: smallest, mean and largest rotation that is reachable in both directions, rad."""
        either = np.minimum(-self.least, self.most)[self.inside]
        known: dict[str, float | None] = {"everywhere": None, "mean": None, "best": None}
        if len(either):
            known = {"everywhere": float(either.min()), "mean": float(either.mean()), "best": float(either.max())}
        return {"about": self.about, **known}

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return its data as arrays for a file."""
        return {"turn_about": np.array(ABOUT.index(self.about)), "turn_least": self.least, "turn_most": self.most}

    @classmethod
    def from_plain(cls, region: Region, arrays: dict[str, NDArray[Any]]) -> Turns:
        """Return the turns from the arrays of `plain`."""
        about, least, most = (arrays[f"turn_{name}"] for name in ("about", "least", "most"))
        return cls(ABOUT[int(about)], least, most, region, np.isfinite(most))


def check_turns(robot: Robot, region: Region, about: object) -> None:
    """Raise CdprError if the robot cannot rotate about the axis, or if there are several attitudes."""
    free = [name for name in ABOUT if name in robot.dof]
    if about not in free:
        known = f"expected one of {', '.join(free)}" if free else "this robot does not turn"
        raise CdprError(f"about: {known}, got {shown(about)}")
    if len(region.orientations) > 1:
        raise CdprError("orientations: turns begin in one attitude")


def turns(
    is_inside: Callable[[Array], NDArray[np.bool_]],
    region: Region,
    about: str,
    inside: NDArray[np.bool_],
    progress: Callable[[int, int], None],
) -> Turns:
    """Return the reachable rotations from the attitude of a region.

    Args:
        is_inside: function that returns True for poses (n, 7) inside.
        region: region whose cells are evaluated at their centres.
        about: world axis.
        inside: (cells,), True for cells inside without rotation.
        progress: called with the number of finished cells and their total.
    """
    ends = np.full((2, region.cells), np.nan)
    for cells in region.pieces():
        here = cells[inside[cells]]
        for k, sign in enumerate((-1.0, 1.0)):
            for first in range(0, len(here), PIECE):
                some = here[first : first + PIECE]
                ends[k, some] = sign * _reached(is_inside, region, about, some, sign)
        progress(int(cells[-1]) + 1, region.cells)
    least, most = ends.reshape(2, *region.shape)
    return Turns(about, least, most, region, inside.reshape(region.shape))


def _reached(
    is_inside: Callable[[Array], NDArray[np.bool_]], region: Region, about: str, cells: NDArray[np.int64], sign: float
) -> Array:
    """Return the angles (n,), at least 0, up to which all steps are inside."""
    poses = np.empty((len(cells), 7))
    poses[:, :3] = region.positions(cells)
    first = region.orientations[0]
    turned = rotations.multiply(np.concatenate([[0.0], np.eye(3)[ABOUT.index(about)]]), first)  # rotated by half a turn
    low, high, going = np.zeros(len(cells)), np.full(len(cells), MOST), np.ones(len(cells), dtype=bool)

    def here(which: NDArray[np.int64], angle: Array) -> NDArray[np.bool_]:
        some = poses[which]
        half = 0.5 * sign * angle
        some[:, 3:] = np.cos(half)[:, None] * first + np.sin(half)[:, None] * turned
        return is_inside(some)

    for k in range(1, round(MOST / STEP) + 1):
        which = np.flatnonzero(going)
        if not len(which):
            break
        found = here(which, np.full(len(which), k * STEP))
        low[which[found]] = k * STEP
        high[which[~found]] = k * STEP
        going[which[~found]] = False
    which = np.flatnonzero(~going)
    for _ in range(HALVINGS):
        middle = 0.5 * (low[which] + high[which])
        found = here(which, middle)
        low[which[found]], high[which[~found]] = middle[found], middle[~found]
    return low
