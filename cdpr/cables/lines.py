"""The ways of a robot's cables from the frame to the platform, as compiled code takes them."""

from __future__ import annotations

from importlib import import_module

import numpy as np

from cdpr.model import Robot
from cdpr.model.address import NUMBER, ROW, VECTOR, address
from cdpr.model.robot import Array, CableExit, frozen_array

# Columns of a row: A_i, world, and B_i, platform axes; addresses of the exit's kernels, all 0 for a point; its numbers.
ANCHORS, LEAVE, WOUND, CARRY, NUMBERS = 6, 6, 7, 8, 9

SIGNATURES = {"leave": VECTOR(ROW, VECTOR), "wound": NUMBER(ROW, VECTOR), "carry": VECTOR(ROW, VECTOR, VECTOR)}


def lines(robot: Robot) -> Array:
    """Return rows (m, 6) of anchors where all cables leave from points, else (m, 9 or more); read-only."""
    exits = [cable.exit for cable in robot.cables]
    if not any(each is not None and each.kernels for each in exits):
        return robot.anchors
    rows = []
    for anchors, each in zip(robot.anchors, exits, strict=True):
        numbers = [] if each is None else each.numbers()
        rows.append([*anchors, *_addresses(each), *numbers])
    width = max(map(len, rows))
    return frozen_array(np.array([row + [0.0] * (width - len(row)) for row in rows]))


def _addresses(each: CableExit | None) -> list[float]:
    if each is None or not each.kernels:
        return [0.0] * len(SIGNATURES)
    module = import_module(each.kernels)
    return [address(getattr(module, name), signature) for name, signature in SIGNATURES.items()]
