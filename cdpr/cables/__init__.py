"""Cable models: chains from the command of each cable to its tension.

A chain is a winch, an exit from the frame and a span. Each part is a file or a folder here with its description, keys
and equations; this file has the tables. The cable models of robot files, `ideal`, `rigid` and `elastic`, are a winch
and a span each:

- `ideal`: T = u, without a winch.
- `rigid`: the cable does not stretch, so the drum moves with it, l' = -r w. Since l' = -W^T twist, the inertias of the
  drums add to the platform's: (M + W m W^T) twist' = W (u - f/r - m W'^T twist) + everything else, m = diag(I / r^2). A
  cable that would have to push is slack, and its drum takes up the slack.
- `elastic`: two states per cable, the unstretched length l0 (m) between drum and platform, l0' = -r w, and w. It starts
  with the first commanded tension and winds at the rate of the length.
- `catenary`: the same winch, with a cable that stretches and sags under its weight (`cdpr.cables.catenary`).
- `tabulated`: the same winch, with a cable that stretches by a measured curve (`cdpr.cables.tabulated`).

In robot files, `inextensible` selects the span alone: it is `rigid` if the winch has an inertia, and `ideal` otherwise.

`winch.type` replaces the winch of a model that stretches: `position` and `velocity` take a length or its rate as their
command (`cdpr.cables.ideal_drive`, `cdpr.cables.servo`); `stepper` takes a length (`cdpr.cables.stepper`). Winches may
have brakes (`cdpr.cables.brake`).

Cables of one robot may differ. The chain is evaluated together with the acceleration: once per step in semi-implicit
engines, which then advance w and after it l0, and at every stage of `reference`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any

from cdpr.base.errors import CdprError
from cdpr.base.kinds import Kinds
from cdpr.cables import brake
from cdpr.cables.catenary import CATENARY
from cdpr.cables.chain import DIAMETER, LINEAR_DENSITY, Chain, Number, Winch
from cdpr.cables.direct import DIRECT
from cdpr.cables.drum import DRUM, RADIUS
from cdpr.cables.elastic import ELASTIC
from cdpr.cables.exit import Exit
from cdpr.cables.ideal_drive import IDEAL_DRIVE
from cdpr.cables.inextensible import INEXTENSIBLE
from cdpr.cables.servo import POSITION_SERVO, VELOCITY_SERVO
from cdpr.cables.stepper import STEPPER, STEPPER_MOTOR, STEPPERS
from cdpr.cables.tabulated import TABULATED
from cdpr.model import Cable, Robot
from cdpr.model.robot import COMMANDED

if TYPE_CHECKING:
    from cdpr.cables.point import Point
    from cdpr.cables.pulley import Pulley
else:
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(__name__, {"Point": "cdpr.cables.point", "Pulley": "cdpr.cables.pulley"})

__all__ = ["COMMANDED", "EXITS", "AnyExit", "Point", "Pulley", "exits_of", "read_exits"]

# Cable models, a winch and a span each. To add one, write its parts, which declare their numbers (see
# `cdpr.cables.chain`), and add it here; robot files can then use it.
MODELS = {
    COMMANDED: Chain(DIRECT, INEXTENSIBLE),
    "rigid": Chain(DRUM, INEXTENSIBLE),
    "elastic": Chain(DRUM, ELASTIC),
    "catenary": Chain(DRUM, CATENARY),
    "tabulated": Chain(DRUM, TABULATED),
}

SPAN_ALONE = "inextensible"  # name in robot files only: see `named`

# Types of winches in robot files, for cables that stretch: each without and with the inertia of a drum.
TORQUE = "torque"
WINCH_TYPES: dict[str, tuple[Winch, Winch]] = {
    TORQUE: (DRUM, DRUM),
    "position": (IDEAL_DRIVE, POSITION_SERVO),
    "velocity": (IDEAL_DRIVE, VELOCITY_SERVO),
    "stepper": (STEPPER, STEPPER_MOTOR),
}
TENSION, LENGTH, RATE = "tension", "length", "rate"  # commands of winches
COMMANDS = {TORQUE: TENSION, "position": LENGTH, "velocity": RATE, "stepper": LENGTH}


def declared(numbers: Iterable[Number]) -> dict[str, Number]:
    """Return numbers by name.

    Raises:
        CdprError: if two differ but have the same name.
    """
    found: dict[str, Number] = {}
    for number in numbers:
        if found.setdefault(number.name, number) != number:
            raise CdprError(f"two parts of cables declare {number.name}: one must import that of the other")
    return found


# Numbers of cables and winches in robot files, by name, in the order of display.
NUMBERS = declared(
    (DIAMETER, *(number for chain in MODELS.values() for number in chain.span.numbers), LINEAR_DENSITY)
) | declared(
    (
        *(number for chain in MODELS.values() for number in chain.winch.accepted),
        *(number for pair in WINCH_TYPES.values() for part in pair for number in part.accepted),
        *brake.NUMBERS,
    )
)

ACTUATED = "elastic"  # model of winches given as an FMU, as exported by cdpr
MIXED = "mixed"  # model of a robot whose cables differ

# Exits from the frame. To add one, write its file (see `cdpr.cables.exit`) and add it here.
EXITS: Kinds[Exit] = Kinds({"point": "cdpr.cables.point:Point", "pulley": "cdpr.cables.pulley:Pulley"})
AnyExit = Annotated[Exit, EXITS]


def names_of_models() -> list[str]:
    """Return the names of the cable models."""
    return list(MODELS)


def names_in_files() -> list[str]:
    """Return the names of cable models in robot files."""
    return [*MODELS, SPAN_ALONE]


def named(model: str, driven: bool) -> str:
    """Return the name in `MODELS` of a cable model of a robot file; `driven` as in `composed`."""
    return ("rigid" if driven else COMMANDED) if model == SPAN_ALONE else model


def keys_of_numbers(owner: str) -> list[str]:
    """Return the keys of the numbers of a "cable" or "winch" in robot files."""
    return [number.key for number in NUMBERS.values() if number.owner == owner]


def keys_of_winch(chain: Chain) -> set[str]:
    """Return the keys of the numbers that a winch uses, including those of a brake."""
    numbers = (*chain.winch.accepted, *(brake.NUMBERS if chain.stretches else ()))
    return {number.key for number in numbers if number.owner == "winch"}


def exits_of(robot: Robot) -> tuple[dict[str, Any] | None, ...]:
    """Return the exits of a robot's cables as plain data, None for a point; () if all are points."""
    plain = [
        cable.exit.model_dump(mode="json", exclude_none=True)
        if isinstance(cable.exit, Exit) and cable.exit.header
        else None
        for cable in robot.cables
    ]
    return tuple(plain) if any(plain) else ()


def read_exits(plain: Sequence[dict[str, Any] | None]) -> list[Exit | None]:
    """Return the exits from the data of `exits_of`."""
    return [None if each is None else EXITS.read(each) for each in plain]


def spans_of(robot: Robot) -> tuple[dict[str, Any] | None, ...]:
    """Return the spans of a robot's cables that bend as plain data, None for others; () if no cable bends."""
    plain: list[dict[str, Any] | None] = []
    for cable in robot.cables:
        span = chain_of(robot, cable).span
        name = cable.model or robot.cable_model
        plain.append({"model": name, "numbers": span.values(cable)} if span.bends else None)
    return tuple(plain) if any(plain) else ()


def chain_of(robot: Robot, cable: Cable) -> Chain:
    """Return winch and span of a cable of this robot."""
    model, winch = cable.model or robot.cable_model, cable.winch
    return MODELS[model] if winch is None else composed(model, winch.type, not math.isnan(winch.inertia))


@lru_cache
def composed(model: str, winch_type: str, driven: bool) -> Chain:
    """Return winch and span of a cable model with a type of winch.

    Args:
        model: name in `MODELS`, or of `names_in_files`.
        winch_type: name in `WINCH_TYPES`; ignored if the span does not stretch.
        driven: True if the winch has the inertia of a drum.
    """
    chain = MODELS[named(model, driven)]
    if not chain.stretches or winch_type == TORQUE:
        return chain
    return Chain(WINCH_TYPES[winch_type][driven], chain.span)


def commands_of(robot: Robot) -> list[str]:
    """Return the quantity that the winch of each cable takes as its command: "tension", "length" or "rate"."""
    return [
        COMMANDS[cable.winch.type] if cable.winch is not None and chain_of(robot, cable).stretches else TENSION
        for cable in robot.cables
    ]


def takes_lengths(robot: Robot) -> bool:
    """Return True if the winch of some cable takes a length or a rate as its command."""
    return any(each != "tension" for each in commands_of(robot))


def has_drum(robot: Robot, cable: Cable) -> bool:
    """Return True if a cable is on a winch that turns, with the radius of a drum."""
    return bool(chain_of(robot, cable).winch.states) and not math.isnan(RADIUS.of(cable, math.nan))


def has_drums(robot: Robot) -> bool:
    """Return True if `has_drum` is true for some cable."""
    return any(has_drum(robot, cable) for cable in robot.cables)


def has_steppers(robot: Robot) -> bool:
    """Return True if the winch of some cable is a stepper."""
    return any(chain_of(robot, cable).winch in STEPPERS for cable in robot.cables)


def names_of_winch_types() -> list[str]:
    """Return the types of winches."""
    return list(WINCH_TYPES)


def model_of(robot: Robot) -> str:
    """Return the common cable model of a robot, or MIXED."""
    models = {cable.model or robot.cable_model for cable in robot.cables}
    return models.pop() if len(models) == 1 else MIXED


def immediate(robot: Robot) -> bool:
    """Return True if the tensions of all cables equal their commands."""
    return all(chain_of(robot, cable).immediate for cable in robot.cables) and not rubs(robot)


def rubs(robot: Robot) -> bool:
    """Return True if some cable loses tension by friction on its exit."""
    return any(cable.exit is not None and cable.exit.rubs for cable in robot.cables)


def bends(robot: Robot) -> bool:
    """Return True if the force of some cable may have another direction than its chord."""
    return any(chain_of(robot, cable).span.bends for cable in robot.cables)


def with_model(robot: Robot, model: str) -> Robot:
    """Return the robot with this model for all its cables."""
    cables = tuple(replace(cable, model=None) for cable in robot.cables)
    return replace(robot, cables=cables, cable_model=model)
