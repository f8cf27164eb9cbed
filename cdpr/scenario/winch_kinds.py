"""Winches of cables in the data of a robot file, for checks before the robot is valid."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from cdpr.base.fields import Section
from cdpr.base.problems import Path
from cdpr.cables import (
    COMMANDED,
    COMMANDS,
    TENSION,
    TORQUE,
    WINCH_TYPES,
    composed,
    keys_of_winch,
    names_in_files,
)
from cdpr.cables.brake import DELAY
from cdpr.cables.brake import TORQUE as BRAKE
from cdpr.cables.chain import Chain
from cdpr.cables.motor import NUMBERS as MOTOR
from cdpr.cables.motor import RESISTANCE, TORQUE_CONSTANT
from cdpr.config.document import Document

Kind = tuple[str, str, bool]  # arguments of `cdpr.cables.composed`


def kind_of(document: Document, root: Path, cable: object) -> Kind | None:
    """Return cable model, type of winch, and whether it has an inertia; None if one is not known.

    Args:
        document: document of the robot.
        root: path of the robot.
        cable: item of its list of cables.
    """
    if not isinstance(cable, dict):
        return None
    model = str(cable.get("model") or document.get((*root, "cable", "model")) or COMMANDED)
    winch = cable.get("winch") or document.get((*root, "winch"))
    own: dict[str, Any] = winch if isinstance(winch, dict) else {}
    kind = str(own.get("type") or TORQUE)
    return (model, kind, own.get("inertia") is not None) if model in names_in_files() and kind in WINCH_TYPES else None


def driven(winch: object) -> bool:
    """Return True if a section of a winch, None if there is none, has the inertia of a drum."""
    return getattr(winch, "inertia", None) is not None


def unused_numbers(winch: Section | None, chains: Iterable[Chain]) -> Iterator[str]:
    """Yield the given numbers of a winch that none of these cables uses, unless they use none at all."""
    used = {key for chain in chains for key in keys_of_winch(chain)}
    for key, info in type(winch).model_fields.items() if winch and used else ():
        if key != "type" and key not in used and getattr(winch, key) != info.default:
            yield key


def command_of(kind: Kind) -> str:
    """Return the command of such a winch, as `cdpr.cables.commands_of`; "" if its cable does not support it."""
    if composed(*kind).stretches:
        return COMMANDS[kind[1]]
    return TENSION if kind[1] == TORQUE else ""


def winch_path(root: Path, cable: object, i: int) -> Path:
    """Return the path of the winch of cable i: its own, or the common one."""
    own = isinstance(cable, dict) and isinstance(cable.get("winch"), dict)
    return (*root, "cables", i, "winch") if own else (*root, "winch")


def wrong_brake(winch: Mapping[str, Any], kinds: Sequence[Kind]) -> Iterator[tuple[str, str]]:
    """Yield the key and a message of each number of a brake that its winch does not support."""
    if winch.get(BRAKE.key) is None:
        if winch.get(DELAY.key) is not None:
            yield DELAY.key, f"delay of a brake, and the winch has none: set {BRAKE.key}, or remove it"
        return
    rigid = next((kind[0] for kind in kinds if not composed(*kind).stretches and kind[0] != COMMANDED), None)
    if rigid is not None:
        yield BRAKE.key, f"a brake needs a cable that stretches, got cable.model {rigid}: set cable.model: elastic"
    if winch.get(DELAY.key) and any(kind[1] != TORQUE and not kind[2] for kind in kinds):
        text = "must be 0 without an inertia: such a drum has no motion without power; set winch.inertia, or remove it"
        yield DELAY.key, text


def wrong_motor(winch: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the key and a message of a number of a motor that needs another one, which the winch does not have."""
    given = [number.key for number in MOTOR if winch.get(number.key) is not None]
    lacking = [number for number in (TORQUE_CONSTANT, RESISTANCE) if number.key not in given]
    if given and lacking:
        missing = " and ".join(f"{number.key} ({number.unit})" for number in lacking)
        yield given[0], f"currents and voltages of a motor need {missing} too: add it from the motor's data sheet"
