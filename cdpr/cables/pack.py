"""Winches and spans of a robot as compiled code takes them: the twin of `cdpr.cables.lines` for what they pull."""

from __future__ import annotations

import math
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from cdpr.cables import chain_of
from cdpr.cables.chain import MOST, Part
from cdpr.model import Cable, Robot
from cdpr.model.address import address
from cdpr.model.kinds import LED, NUMBER, PAIR, ROW, VECTOR
from cdpr.model.robot import Array, frozen_array

# Columns of a row: the lowest tension there can be, 0 or, for rigid legs, minus infinity; addresses of the kernels, 0
# where there are none: of a span that bends PULL is 0 and BENT_PULL is not, and all that stretch have a REST; the
# winch's numbers, the first of which is cable per unit of its coordinate; the span's.
LOWEST, HELD, TURN, PULL, BENT_PULL, REST = range(6)
WINCH = 6
SPAN = WINCH + MOST
END = SPAN + MOST

DRIVE = {
    "held": PAIR(ROW, NUMBER, NUMBER, NUMBER),
    "turn": NUMBER(ROW, NUMBER, NUMBER, NUMBER),
}
STRAIGHT = {
    "pull": NUMBER(ROW, NUMBER, NUMBER, NUMBER, NUMBER),
    "rest": NUMBER(ROW, NUMBER, NUMBER),
}
BENT = {
    "pull": LED(ROW, VECTOR, NUMBER, NUMBER, NUMBER, NUMBER, VECTOR),
    "rest": NUMBER(ROW, VECTOR, NUMBER, NUMBER, VECTOR),
}


def pack(robot: Robot) -> Array:
    """Return rows (m, END), SI units, columns as named above; CdprError where a cable lacks what its model needs."""
    rows = []
    for cable in robot.cables:
        chain = chain_of(robot, cable)
        pull, rest = _addresses(chain.span, BENT if chain.span.bends else STRAIGHT)
        pulls = (0.0, pull) if chain.span.bends else (pull, 0.0)
        calls = [*_addresses(chain.winch, DRIVE), *pulls, rest]
        rows.append(
            [
                0.0 if robot.unilateral else -math.inf,
                *calls,
                *_numbers(chain.winch, cable),
                *_numbers(chain.span, cable),
            ]
        )
    return frozen_array(rows)


def _addresses(part: Part, signatures: Mapping[str, Any]) -> list[float]:
    if not part.kernels:
        return [0.0] * len(signatures)
    module = import_module(part.kernels)
    return [address(getattr(module, name), signature) for name, signature in signatures.items()]


def _numbers(part: Part, cable: Cable) -> list[float]:
    return [*(number.of(cable) for number in part.numbers), *[0.0] * (MOST - len(part.numbers))]
