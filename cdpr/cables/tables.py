"""Tables of a robot's cables for the kernel library, and compiled functions of the chain winch -> exit -> span.

Layouts: `include/cdpr/geometry.hpp` (lines) and `include/cdpr/chain.hpp` (chains). The kind of a part is its index in
the tables below, which `include/cdpr/parts.hpp` repeats.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.errors import CdprError
from cdpr.cables import EXITS, MODELS, chain_of
from cdpr.cables.chain import MOST, Part, Span, Winch
from cdpr.model import Cable, Robot
from cdpr.model.robot import Array, CableExit, frozen_array
from cdpr.native.arrays import real, reals
from cdpr.native.bind import bind

WINCHES: tuple[Winch, ...] = tuple(dict.fromkeys(chain.winch for chain in MODELS.values()))
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
    return line_rows(robot.anchors, [cable.exit for cable in robot.cables])


def line_rows(anchors: Array, exits: Sequence[CableExit | None]) -> Array:
    """Return the table of `line_table` for anchors (m, 6) and exits, None for a point."""
    if exits.count(None) == len(exits):
        return anchors
    kinds = [0 if each is None else _kind(EXITS, type(each)) for each in exits]
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
        (m, 19), read-only, SI units.

    Raises:
        CdprError: if a cable lacks a number that its model requires.

    Example:
        >>> import cdpr
        >>> chain_table(cdpr.load_robot("caroca_winches")).shape
        (8, 19)
    """
    lowest = 0.0 if robot.unilateral else -math.inf
    rows = []
    for cable in robot.cables:
        chain = chain_of(robot, cable)
        kinds = [float(_kind(WINCHES, chain.winch)), float(_kind(SPANS, chain.span))]
        rows.append([*kinds, lowest, *_numbers(chain.winch, cable), *_numbers(chain.span, cable)])
    return frozen_array(rows)


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


def chain_tensions(
    chains: Array,
    command: ArrayLike,
    length: ArrayLike,
    rate: ArrayLike,
    length_acceleration: ArrayLike,
    unwound: ArrayLike,
    speed: ArrayLike,
) -> tuple[Array, Array]:
    """Return the tensions of all cables from the commands and states of their winches.

    Equations: `cdpr.cables.drum` (thesis 2.20 to 2.24) and `cdpr.cables.elastic`.

    Args:
        chains: (m, 19), as in `chain_table`.
        command: (m,) N, tension that the winch would hold at rest.
        length: (m,) m, of the cable from its winch's end of the exit to the platform.
        rate: (m,) m/s, rate of the length.
        length_acceleration: (m,) m/s^2, derivative of the rate if the platform did not accelerate.
        unwound: (m,) m, unstretched length; only used for cables that stretch.
        speed: (m,) rad/s, of the winches, positive when winding in; only used for cables that stretch.

    Returns:
        Tensions (m,) N, without the effect of the winches' inertia when the platform accelerates, and that inertia as
            masses along the cables (m,) kg.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> import numpy as np
        >>> table, one = chain_table(cdpr.load_robot("caroca_winches")), np.ones(8)
        >>> tension, mass = chain_tensions(table, 50.0 * one, 3.0 * one, 0.0 * one, 0.0 * one, 2.99 * one, 0.0 * one)
        >>> tension.shape, mass.shape
        ((8,), (8,))
    """
    arrays = reals(
        chains=chains,
        command=command,
        length=length,
        rate=rate,
        length_acceleration=length_acceleration,
        unwound=unwound,
        speed=speed,
    )
    tension, mass = np.empty(arrays["command"].shape), np.empty(arrays["command"].shape)
    bind("chain_tensions", **arrays, tension=tension, mass=mass)()
    return tension, mass


def chain_slopes(chains: Array, command: ArrayLike, tension: ArrayLike, speed: ArrayLike) -> tuple[Array, Array]:
    """Return the derivatives of the winches' states; 0 for cables that do not stretch.

    Args:
        chains: (m, 19), as in `chain_table`.
        command: (m,) N.
        tension: (m,) N.
        speed: (m,) rad/s, of the winches.

    Returns:
        Derivatives of the unwound lengths (m,) m/s and of the speeds (m,) rad/s^2.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> import numpy as np
        >>> table, one = chain_table(cdpr.load_robot("caroca_winches")), np.ones(8)
        >>> unwinding, acceleration = chain_slopes(table, 50.0 * one, 50.0 * one, 0.0 * one)
        >>> unwinding.shape, acceleration.shape
        ((8,), (8,))
    """
    arrays = reals(chains=chains, command=command, tension=tension, speed=speed)
    unwinding, acceleration = np.empty(arrays["command"].shape), np.empty(arrays["command"].shape)
    bind("chain_slopes", **arrays, unwinding=unwinding, acceleration=acceleration)()
    return unwinding, acceleration


def chain_start(chains: Array, command: ArrayLike, length: ArrayLike, rate: ArrayLike) -> tuple[Array, Array]:
    """Return the states of the winches at which each tension equals its command and no cable stretches further.

    Args:
        chains: (m, 19), as in `chain_table`.
        command: (m,) N.
        length: (m,) m.
        rate: (m,) m/s.

    Returns:
        Unwound lengths (m,) m and speeds (m,) rad/s; 0 for cables that do not stretch.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> import numpy as np
        >>> table, one = chain_table(cdpr.load_robot("caroca_winches")), np.ones(8)
        >>> unwound, speed = chain_start(table, 50.0 * one, 3.0 * one, 0.0 * one)
        >>> unwound.shape, speed.shape
        ((8,), (8,))
    """
    arrays = reals(chains=chains, command=command, length=length, rate=rate)
    unwound, speed = np.empty(arrays["command"].shape), np.empty(arrays["command"].shape)
    bind("chain_start", **arrays, unwound=unwound, speed=speed)()
    return unwound, speed


def _kind(table: tuple[object, ...], part: object) -> int:
    if part not in table:
        raise CdprError(f"{part}: a part of a cable that is not in the tables of cdpr.cables")
    return table.index(part)


def _numbers(part: Part, cable: Cable) -> list[float]:
    return [*(number.of(cable) for number in part.numbers), *[0.0] * (MOST - len(part.numbers))]
