"""Tables of a robot's cables for the kernel library, and the compiled geometry of exits.

Layouts: `cdpr/mechanics/geometry.hpp` (lines) and `cdpr/cables/chain.hpp` (chains). The kind of a part is its index in
the tables below, which `cdpr/cables/parts.hpp` repeats.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.base.errors import CdprError
from cdpr.cables import EXITS, LENGTH, MODELS, RATE, TENSION, WINCH_TYPES, chain_of, commands_of, has_drum
from cdpr.cables.chain import MOST, Number, Part, Span, Winch
from cdpr.cables.drum import RADIUS
from cdpr.cables.transmission import COULOMB_SPEED, EFFICIENCY, GROWTH, KERNEL
from cdpr.model import Cable, Robot
from cdpr.model.home import home_pose
from cdpr.model.robot import Array, CableExit, frozen_array
from cdpr.model.rotations import matrix
from cdpr.native.arrays import real
from cdpr.native.bind import bind

WINCHES: tuple[Winch, ...] = tuple(
    dict.fromkeys(
        (*(chain.winch for chain in MODELS.values()), *(part for pair in WINCH_TYPES.values() for part in pair))
    )
)
# Columns of `chain_table`: the first numbers of winch, transmission and span, and their number; see
# `cdpr/cables/chain.hpp`. The first number of a winch is the cable per unit of its coordinate at the home pose.
WINCH, TRANSMISSION = 3, 3 + MOST
HOME = TRANSMISSION + len(KERNEL)
SPAN = HOME + 1
CHAIN_WIDTH = SPAN + MOST
KINDS_OF_COMMANDS = (TENSION, LENGTH, RATE)  # in the order of `CommandKind`, parts.hpp
SPANS: tuple[Span, ...] = tuple(dict.fromkeys(chain.span for chain in MODELS.values()))


def line_table(robot: Robot) -> Array:
    """Return the anchors and exits of a robot's cables.

    Args:
        robot: the robot.

    Returns:
        (m, 6), read-only: A_i, world, and B_i, platform axes, m. If a cable does not leave from a point, (m, w): then
            the kind of the exit and its numbers.

    Example:
        >>> import cdpr
        >>> line_table(cdpr.load_robot("caroca")).shape
        (8, 6)
    """
    for cable in robot.cables if not robot.unilateral else ():
        if cable.exit is not None and cable.exit.rubs:
            raise CdprError(f"cable '{cable.name}': friction on its exit: not supported for rigid legs, which push")
    return line_rows(robot.anchors, [cable.exit for cable in robot.cables])


def line_rows(anchors: Array, exits: Sequence[CableExit | None]) -> Array:
    """Return the table of `line_table` for anchors (m, 6) and exits, None for a point."""
    if exits.count(None) == len(exits):
        return anchors
    kinds = [0 if each is None else _kind(tuple(EXITS), each.type) for each in exits]
    if not any(kinds):
        return anchors
    numbers = [[] if each is None else list(each.numbers()) for each in exits]
    width = max(map(len, numbers))
    return frozen_array(
        [
            [*ends, float(kind), *own, *[0.0] * (width - len(own))]
            for ends, kind, own in zip(anchors.tolist(), kinds, numbers, strict=True)
        ]
    )


def chain_table(robot: Robot) -> Array:
    """Return the winches and spans of a robot's cables.

    Args:
        robot: the robot.

    Returns:
        (m, 33), read-only, SI units.

    Raises:
        CdprError: if a cable lacks a number that its model requires.

    Example:
        >>> import cdpr
        >>> chain_table(cdpr.load_robot("caroca_winches")).shape
        (8, 33)
    """
    lowest = 0.0 if robot.unilateral else -math.inf
    rows = []
    for cable, home in zip(robot.cables, home_lengths(robot).tolist(), strict=True):
        chain = chain_of(robot, cable)
        kinds = [float(_kind(WINCHES, chain.winch)), float(_kind(SPANS, chain.span))]
        transmission = transmission_numbers(cable, chain.winch.transmission, robot.unilateral)
        transmission.append(home if has_drum(robot, cable) else math.nan)
        rows.append([*kinds, lowest, *_numbers(chain.winch, cable), *transmission, *_numbers(chain.span, cable)])
    return frozen_array(rows)


def span_table(spans: Sequence[dict[str, Any] | None]) -> Array:
    """Return the spans of cables from the data of `cdpr.cables.spans_of`.

    Returns:
        (m, 33), as in `chain_table`, without the numbers of winches and of cables that do not bend.
    """
    table = np.zeros((len(spans), CHAIN_WIDTH))
    for row, each in zip(table, spans, strict=True):
        if each is not None:
            numbers = each["numbers"]
            row[1], row[SPAN : SPAN + len(numbers)] = _kind(SPANS, MODELS[each["model"]].span), numbers
    return table


def home_lengths(robot: Robot) -> Array:
    """Return the lengths of the cables' paths at the home pose, (m,), m; NaN if no cable leads there."""
    home, _ = home_pose(robot)
    tips = home[:3] + robot.anchors[:, 3:] @ matrix(home[3:]).T
    point, _, wrapped_length = exits(line_table(robot), tips)
    return np.asarray(np.linalg.norm(point - tips, axis=1) + wrapped_length)


def transmission_numbers(cable: Cable, accepted: Sequence[Number], unilateral: bool = True) -> list[float]:
    """Return the numbers of a cable's transmission, as in transmission.hpp; the defaults of numbers not accepted.

    Raises:
        CdprError: for losses of legs that push, or a drum that grows without a radius.
    """
    values = {number: number.of(cable) if number in accepted else number.default or 0.0 for number in KERNEL}
    if EFFICIENCY in accepted:
        values[COULOMB_SPEED] = COULOMB_SPEED.of(cable)
    if values[EFFICIENCY] != 1.0 and not unilateral:
        raise CdprError(f"cable '{cable.name}': {EFFICIENCY.name}: not supported for rigid legs, which push")
    if values[GROWTH] != 0.0 and cable.winch is not None and math.isnan(cable.winch.drum_radius):
        raise CdprError(f"cable '{cable.name}': {GROWTH.name} needs {RADIUS.name}, the radius at the home pose")
    return list(values.values())


def reached_by_rate(robot: Robot) -> NDArray[np.bool_]:
    """Return True for winches that take a length, (m,), which their kernels reach at a rate that the loop commands."""
    kernels = [chain_of(robot, cable).winch.command for cable in robot.cables]
    return np.array([one == LENGTH != other for one, other in zip(commands_of(robot), kernels, strict=True)])


def command_kinds(robot: Robot) -> NDArray[np.int64]:
    """Return the kind of each winch's command, (m,): an index in `KINDS_OF_COMMANDS`."""
    return np.array([KINDS_OF_COMMANDS.index(each) for each in commands_of(robot)], dtype=np.int64)


def places_of_states(robot: Robot) -> NDArray[np.int64]:
    """Return the places of the winches' state numbers in the state vector of a plant.

    Args:
        robot: the robot.

    Returns:
        (m + 1,): the index of the first state of each winch, and the number of all states. Cables have as many as their
            chain declares (`cdpr.cables.chain.Chain.states`).

    Example:
        >>> import cdpr
        >>> places_of_states(cdpr.load_robot("caroca_winches"))
        array([ 0,  2,  4,  6,  8, 10, 12, 14, 16])
    """
    widths = [chain_of(robot, cable).states for cable in robot.cables]
    return np.concatenate([[0], np.cumsum(widths)]).astype(np.int64)


def exits(lines: Array, tips: ArrayLike, velocities: ArrayLike | None = None) -> tuple[Array, Array, Array]:
    """Return the points at which cables leave the frame on their way to given anchors on the platform.

    Args:
        lines: (m, w), as in `line_table`.
        tips: (m, 3) m, anchors on the platform, world frame.
        velocities: (m, 3) m/s, of the tips, world axes; 0 by default.

    Returns:
        Exit points (m, 3) m, world frame; their velocities (m, 3) m/s; lengths of cable on the exits (m,) m. NaN if no
            cable leads there (`cdpr.cables.pulley`).

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> robot = cdpr.load_robot("caroca")
        >>> points, velocities, wrapped_length = exits(line_table(robot), robot.anchors[:, 3:])
        >>> bool((points == robot.anchors[:, :3]).all()), wrapped_length.shape
        (True, (8,))
    """
    tip = real(tips, "tips")
    velocity = np.zeros(tip.shape) if velocities is None else real(velocities, "velocities")
    point, moving, wrapped_length = np.empty(tip.shape), np.empty(tip.shape), np.empty(len(tip))
    bind(
        "exits",
        lines=real(lines, "lines"),
        tip=tip,
        velocity=velocity,
        point=point,
        moving=moving,
        wrapped_length=wrapped_length,
    )()
    return point, moving, wrapped_length


def _kind(table: tuple[object, ...], part: object) -> int:
    if part not in table:
        raise CdprError(f"{part}: a part of a cable that is not in the tables of cdpr.cables")
    return table.index(part)


def _numbers(part: Part, cable: Cable) -> list[float]:
    return [*part.values(cable), *[0.0] * (MOST - len(part.numbers))]
