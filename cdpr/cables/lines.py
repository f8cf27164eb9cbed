"""The ways of a robot's cables from the frame to the platform, as compiled code takes them."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module

from cdpr.model import Robot
from cdpr.model.address import address
from cdpr.model.kinds import LED, ROW, VECTOR
from cdpr.model.robot import Array, CableExit, frozen_array

# Columns of a row: A_i, world, and B_i, platform axes; addresses of the exit's kernels, all 0 for a point; its numbers.
ANCHORS, LEAVE, LEAD, CARRY, NUMBERS = 6, 6, 7, 8, 9

SIGNATURES = {"leave": VECTOR(ROW, VECTOR), "lead": LED(ROW, VECTOR), "carry": VECTOR(ROW, VECTOR, VECTOR)}


def lines(robot: Robot) -> Array:
    """Return rows (m, 6) of anchors where all cables leave from points, else (m, 9 or more); read-only."""
    return rows(robot.anchors, [cable.exit for cable in robot.cables])


def rows(anchors: Array, exits: Sequence[CableExit | None]) -> Array:
    """Return what `lines` does of anchors (m, 6) and what the cables leave the frame by."""
    if not any(each is not None and each.kernels for each in exits):
        return anchors
    given = [
        [*ends, *_addresses(each), *([] if each is None else each.numbers())]
        for ends, each in zip(anchors.tolist(), exits, strict=True)
    ]
    width = max(map(len, given))
    return frozen_array([row + [0.0] * (width - len(row)) for row in given])


def _addresses(each: CableExit | None) -> list[float]:
    if each is None or not each.kernels:
        return [0.0] * len(SIGNATURES)
    module = import_module(each.kernels)
    return [address(getattr(module, name), signature) for name, signature in SIGNATURES.items()]
