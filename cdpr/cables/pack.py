"""Winches and spans of a robot as compiled code takes them: the twin of `cdpr.cables.lines` for what they pull."""

from __future__ import annotations

import math
from collections.abc import Sequence
from importlib import import_module

from cdpr.cables import chain_of
from cdpr.cables.chain import MOST, Part
from cdpr.model import Cable, Robot
from cdpr.model.address import NUMBER, PAIR, ROW, address
from cdpr.model.robot import Array, frozen_array

# Columns of a row: the lowest tension there can be, 0 or, for rigid legs, minus infinity; addresses of the kernels, 0
# where there are none; the winch's numbers, the first of which is cable per unit of its coordinate; the span's.
LOWEST, HELD, TURN, PULL, REST = range(5)
WINCH = 5
SPAN = WINCH + MOST
END = SPAN + MOST

SIGNATURES = {
    "held": PAIR(ROW, NUMBER, NUMBER, NUMBER),
    "turn": NUMBER(ROW, NUMBER, NUMBER, NUMBER),
    "pull": NUMBER(ROW, NUMBER, NUMBER, NUMBER, NUMBER),
    "rest": NUMBER(ROW, NUMBER, NUMBER),
}


def pack(robot: Robot) -> Array:
    """Return rows (m, END), SI units, columns as named above; CdprError where a cable lacks what its model needs."""
    rows = []
    for cable in robot.cables:
        chain = chain_of(robot, cable)
        calls = [*_addresses(chain.winch, ("held", "turn")), *_addresses(chain.span, ("pull", "rest"))]
        rows.append(
            [
                0.0 if robot.unilateral else -math.inf,
                *calls,
                *_numbers(chain.winch, cable),
                *_numbers(chain.span, cable),
            ]
        )
    return frozen_array(rows)


def _addresses(part: Part, names: Sequence[str]) -> list[float]:
    if not part.kernels:
        return [0.0] * len(names)
    module = import_module(part.kernels)
    return [address(getattr(module, name), SIGNATURES[name]) for name in names]


def _numbers(part: Part, cable: Cable) -> list[float]:
    return [*(number.of(cable) for number in part.numbers), *[0.0] * (MOST - len(part.numbers))]
