"""From the command of each cable to its tension: a winch, an exit from the frame and a span; and the cable models.

Each part is a file or a folder here, with what it is, its keys and its equations; this file holds the tables. `ideal`,
`rigid` and `elastic`, what a robot file calls a cable model, are a winch and a span each:

- `ideal`: T = u. No winch takes part.
- `rigid`: the cable does not stretch, so the drum goes with it, l' = -r w. Since l' = -W^T twist, the inertias of the
  drums add to the platform's: (M + W m W^T) twist' = W (u - f/r - m W'^T twist) + everything else, m = diag(I / r^2). A
  cable that would have to push hangs slack, and its drum takes up what it leaves.
- `elastic`: two states a cable, the unstretched length l0 (m) between drum and platform, l0' = -r w, and w. It starts
  with the tension that is commanded first, winding as fast as the length changes.

Cables of one robot may differ. All of it is evaluated wherever the integrator evaluates the acceleration: once a step
in semi-implicit engines, which then advance w and after it l0, and at every stage of `reference`.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache
from typing import Annotated, Any, get_args

from pydantic import Field, TypeAdapter

from cdpr.cables.chain import DIAMETER, LINEAR_DENSITY, Chain, Number
from cdpr.cables.direct import DIRECT
from cdpr.cables.drum import DRUM
from cdpr.cables.elastic import ELASTIC
from cdpr.cables.exit import Exit
from cdpr.cables.inextensible import INEXTENSIBLE
from cdpr.cables.point import Point
from cdpr.cables.pulley import Pulley
from cdpr.errors import CdprError
from cdpr.model import Cable, Robot
from cdpr.model.robot import COMMANDED

__all__ = ["COMMANDED", "EXITS", "AnyExit", "Point", "Pulley", "exits_of", "read_exits"]

# Cable models: a winch and a span each. To add one, write its parts, which declare their numbers (see
# `cdpr.cables.chain`), and name it here: robot files may then say these.
MODELS = {
    COMMANDED: Chain(DIRECT, INEXTENSIBLE),
    "rigid": Chain(DRUM, INEXTENSIBLE),
    "elastic": Chain(DRUM, ELASTIC),
}


def declared(numbers: Iterable[Number]) -> dict[str, Number]:
    """Return them by their names; CdprError where two have one name."""
    found: dict[str, Number] = {}
    for number in numbers:
        if found.setdefault(number.name, number) != number:
            raise CdprError(f"two parts of cables declare {number.name}: one must take that of the other")
    return found


# What a robot file may say of cables and of winches, by name, in the order in which it is told.
NUMBERS = declared(
    (DIAMETER, *(number for chain in MODELS.values() for number in chain.span.numbers), LINEAR_DENSITY)
) | declared(number for chain in MODELS.values() for number in chain.winch.numbers)

ACTUATED = "elastic"  # of winches that come as an FMU: what cdpr exports of a robot's
MIXED = "mixed"  # the model of a robot whose cables differ

# Where a cable leaves the frame. To add one, write its file (see `cdpr.cables.exit`) and name it here.
AnyExit = Annotated[Point | Pulley, Field(discriminator="type")]

EXITS: tuple[type[Exit], ...] = get_args(get_args(AnyExit)[0])


def exits_of(robot: Robot) -> tuple[dict[str, Any] | None, ...]:
    """Return the exits of a robot's cables as plain data, None for a point; () where all are."""
    plain = [
        cable.exit.model_dump(mode="json") if isinstance(cable.exit, Exit) and cable.exit.header else None
        for cable in robot.cables
    ]
    return tuple(plain) if any(plain) else ()


def read_exits(plain: Sequence[dict[str, Any] | None]) -> list[Exit | None]:
    """Undo `exits_of`."""
    return [None if each is None else _exits().validate_json(json.dumps(each)) for each in plain]


@cache
def _exits() -> TypeAdapter[Exit]:
    """What reads one: made where it is needed, for that takes a millisecond."""
    return TypeAdapter(AnyExit)


def chain_of(robot: Robot, cable: Cable) -> Chain:
    """Return winch and span of a cable of this robot."""
    return MODELS[cable.model or robot.cable_model]


def model_of(robot: Robot) -> str:
    """Return the cable model that all cables of a robot share, or MIXED."""
    models = {cable.model or robot.cable_model for cable in robot.cables}
    return models.pop() if len(models) == 1 else MIXED


def immediate(robot: Robot) -> bool:
    """Tell whether the tensions of all cables are their commands."""
    return all(chain_of(robot, cable).immediate for cable in robot.cables)


def with_model(robot: Robot, model: str) -> Robot:
    """Return the robot with this model for all its cables."""
    cables = tuple(replace(cable, model=None) for cable in robot.cables)
    return replace(robot, cables=cables, cable_model=model)
