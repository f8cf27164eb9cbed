"""Share of a static workspace that is free of interference, estimated on a grid of upright poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cdpr.mechanics.touching import diameters, with_diameters
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.scenario.hold import held

CELLS = 8  # along each side of the grid


@dataclass(frozen=True)
class FreeShare:
    """Counts of upright poses.

    Attributes:
        poses: on the grid, and home.
        static: those at which the cables hold the weight.
        free: those of them at which no cable touches another or the platform.
        home: whether none does at home.
        diameter: of the thickest cable, given or assumed, m.
    """

    poses: int
    static: int
    free: int
    home: bool
    diameter: float

    @property
    def value(self) -> float:
        """Share of the static poses that are free; 0 without any."""
        return self.free / self.static if self.static else 0.0


def free_share(robot: Robot, low: Array, high: Array, gravity: Array) -> FreeShare:
    """Count poses of a robot with a home.

    Args:
        robot: gives home, cables and shape.
        low: (3,) m, lowest positions of the grid.
        high: (3,) m, highest ones.
        gravity: (3,) m/s^2, world.
    """
    from cdpr.mechanics.clearance import clearance  # loads kernels

    assert robot.home is not None
    middles = (np.arange(CELLS) + 0.5) / CELLS
    sides = [np.unique(a + (b - a) * middles) for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
    positions = np.vstack([robot.home[:3], grid])
    static = held(robot, positions, robot.home[3:], gravity)
    poses = np.hstack([positions, np.tile(robot.home[3:], (len(positions), 1))])
    gaps, _ = clearance(with_diameters(robot)).at(poses, jobs=1)
    free = gaps > 0.0
    return FreeShare(len(poses), int(static.sum()), int((static & free).sum()), bool(free[0]), max(diameters(robot)))
