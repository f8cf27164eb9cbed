"""Interference-free fraction of a static workspace, estimated on a grid of upright poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cdpr.mechanics.assumed_diameters import diameters, with_diameters
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.scenario.static_feasibility import held

CELLS = 8  # along each side of the grid


@dataclass(frozen=True)
class FreeShare:
    """Counts of upright poses.

    Attributes:
        poses: number of poses: grid and home.
        static: poses at which the cables balance the weight.
        free: static poses at which no cable touches another or the platform.
        home: True if no cable touches anything at home.
        diameter: diameter of the thickest cable, given or assumed, m.
    """

    poses: int
    static: int
    free: int
    home: bool
    diameter: float

    @property
    def value(self) -> float:
        """Fraction of the static poses that are free of interference; 0 without static poses."""
        return self.free / self.static if self.static else 0.0


def free_share(robot: Robot, low: Array, high: Array, gravity: Array) -> FreeShare:
    """Return the counts for a robot with a home.

    Args:
        robot: the robot.
        low: (3,), m, lower corner of the grid.
        high: (3,), m, upper corner of the grid.
        gravity: (3,), m/s^2, world frame.
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
