"""How far a platform can turn at each position, either way from its attitude, without leaving a workspace.

A turn is gone along in steps until one is outside, and the way back is halved: what is narrower than a step is missed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.errors import CdprError
from cdpr.model import Robot, rotations
from cdpr.model.robot import Array
from cdpr.workspace.regions import PIECE, Region

ABOUT = ("rx", "ry", "rz")
STEP = np.pi / 36.0  # rad, 5 degrees
HALVINGS = 12  # of a step, to a thousandth of a degree
MOST = np.pi  # rad, either way


@dataclass(frozen=True, eq=False)
class Turns:
    """Turns that can be reached.

    Attributes:
        about: "rx", "ry" or "rz", axes of the world through the platform's origin.
        least, most: (nx, ny, nz), rad, at most 0 and at least 0, of positions inside; NaN of others.
        region: whose cells they are.
        inside: (nx, ny, nz), of positions in the attitude itself.
    """

    about: str
    least: Array
    most: Array
    region: Region
    inside: NDArray[np.bool_]

    @property
    def volume(self) -> float:
        """Size of what is inside in the attitude itself."""
        return float(self.inside.sum()) * self.region.cell

    def told(self) -> dict[str, Any]:
        """Return its figures: of how far the platform can turn either way, the least and the mean, rad."""
        either = np.minimum(-self.least, self.most)[self.inside]
        known: dict[str, float | None] = {"everywhere": None, "mean": None, "best": None}
        if len(either):
            known = {"everywhere": float(either.min()), "mean": float(either.mean()), "best": float(either.max())}
        return {"about": self.about, **known}

    def plain(self) -> dict[str, NDArray[Any]]:
        """Return it as arrays, which a file holds."""
        return {"turn_about": np.array(ABOUT.index(self.about)), "turn_least": self.least, "turn_most": self.most}

    @classmethod
    def from_plain(cls, region: Region, arrays: dict[str, NDArray[Any]]) -> Turns:
        """Undo `plain`."""
        about, least, most = (arrays[f"turn_{name}"] for name in ("about", "least", "most"))
        return cls(ABOUT[int(about)], least, most, region, np.isfinite(most))


def check_turns(robot: Robot, region: Region, about: object) -> None:
    """Raise CdprError where a robot cannot turn about an axis, or from several attitudes."""
    free = [name for name in ABOUT if name in robot.dof]
    if about not in free:
        known = f"one of {', '.join(free)} is expected" if free else "this robot does not turn"
        raise CdprError(f"about: {known}, got {about!r}")
    if len(region.orientations) > 1:
        raise CdprError("orientations: turns begin in one attitude")


def turns(
    ask: Callable[[Array], NDArray[np.bool_]],
    region: Region,
    about: str,
    inside: NDArray[np.bool_],
    progress: Callable[[int, int], None],
) -> Turns:
    """Return how far the platform can turn from the attitude of a region.

    Args:
        ask: tells of poses (n, 7) whether they are inside.
        region: whose cells, in their middles, are looked at.
        about: an axis of the world.
        inside: (cells,), which are in the attitude itself.
        progress: called with the number of cells that are done, and of all.
    """
    ends = np.full((2, region.cells), np.nan)
    for cells in region.pieces():
        here = cells[inside[cells]]
        for k, sign in enumerate((-1.0, 1.0)):
            for first in range(0, len(here), PIECE):
                some = here[first : first + PIECE]
                ends[k, some] = sign * _reached(ask, region, about, some, sign)
        progress(int(cells[-1]) + 1, region.cells)
    least, most = ends.reshape(2, *region.shape)
    return Turns(about, least, most, region, inside.reshape(region.shape))


def _reached(
    ask: Callable[[Array], NDArray[np.bool_]], region: Region, about: str, cells: NDArray[np.int64], sign: float
) -> Array:
    """Angles (n,), at least 0, up to which all steps are inside."""
    poses = np.empty((len(cells), 7))
    poses[:, :3] = region.positions(cells)
    first = region.orientations[0]
    turned = rotations.multiply(np.concatenate([[0.0], np.eye(3)[ABOUT.index(about)]]), first)  # by half a turn
    low, high, going = np.zeros(len(cells)), np.full(len(cells), MOST), np.ones(len(cells), dtype=bool)

    def here(which: NDArray[np.int64], angle: Array) -> NDArray[np.bool_]:
        some = poses[which]
        half = 0.5 * sign * angle
        some[:, 3:] = np.cos(half)[:, None] * first + np.sin(half)[:, None] * turned
        return ask(some)

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
