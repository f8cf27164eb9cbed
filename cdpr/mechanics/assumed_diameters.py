"""Interference at single poses, with assumed diameters for cables without a diameter."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.model.shapes import Obstacle

# Assumed diameter of a cable: usual for robots of some metres, smaller for small robots.
ASSUMED_DIAMETER = 0.01  # [m]
ASSUMED_SHARE = 0.005  # upper limit as a share of the diagonal of the box around the frame's anchors


def assumed_diameter(robot: Robot) -> float:
    """Return the diameter of cables without a diameter of their own [m]."""
    extent = float(np.linalg.norm(np.ptp(robot.anchors[:, :3], axis=0)))
    return min(ASSUMED_DIAMETER, ASSUMED_SHARE * extent)


def diameters(robot: Robot) -> list[float]:
    """Return the diameter of each cable, its own or the assumed one [m]."""
    assumed = assumed_diameter(robot)
    return [assumed if cable.diameter is None else cable.diameter for cable in robot.cables]


def with_diameters(robot: Robot) -> Robot:
    """Return the same robot with a diameter for each cable."""
    sizes = diameters(robot)
    cables = tuple(replace(cable, diameter=size) for cable, size in zip(robot.cables, sizes, strict=True))
    return replace(robot, cables=cables)


def least_clearance(
    robot: Robot,
    pose: Array,
    obstacles: Sequence[Obstacle] = (),
    *,
    unwound: Array | None = None,
    gravity: Array | None = None,
) -> tuple[float, str] | None:
    """Return the least clearance at a pose (7,) [m] and the names of the bodies, None if nothing can touch.

    With unwound lengths (1, m) [m] and gravity (3,) [m/s^2], cables that sag are curves.
    """
    from cdpr.mechanics.clearance import clearance  # loads the kernel library

    among = clearance(with_diameters(robot), obstacles, gravity=gravity)
    gaps, which = among.at(pose[None], unwound=unwound)
    return (float(gaps[0]), among.name(int(which[0]))) if math.isfinite(gaps[0]) else None


def assumption(robot: Robot) -> str:
    """Return the statement of an assumed diameter, empty if all cables have their own."""
    if all(cable.diameter is not None for cable in robot.cables):
        return ""
    return f", with an assumed cable diameter of {1e3 * assumed_diameter(robot):.3g} mm"
