"""Drums at given lengths or angles: their radii, angles, speeds and losses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cdpr.cables import chain_of
from cdpr.cables.chain import Number
from cdpr.cables.drum import RADIUS
from cdpr.cables.tables import home_lengths, transmission_numbers
from cdpr.cables.transmission import GROWTH, KERNEL, REEVING
from cdpr.model import Cable, Robot
from cdpr.model.robot import Array
from cdpr.native.arrays import real
from cdpr.native.bind import bind

EMPTY = 0.1  # share of the radius at the home pose, of a drum that grows


@dataclass(frozen=True, eq=False)
class DrumMotion:
    """Motion of the drums of m cables at K samples; NaN for cables without a drum.

    Attributes:
        angle: (K, m) rad, 0 at the home pose, positive after winding in.
        per_turn: (K, m) m/rad, length by which the cable shortens per angle.
        speed: (K, m) rad/s, positive when winding in.
        acceleration: (K, m) rad/s^2.
        load: (K, m) torque that moves the cable, relative to that without losses.
    """

    angle: Array
    per_turn: Array
    speed: Array
    acceleration: Array
    load: Array


def drum_motion(robot: Robot, unwound: ArrayLike, rate: ArrayLike, acceleration: ArrayLike) -> DrumMotion:
    """Compute the motion of the drums from that of their cables.

    Args:
        robot: the robot; the drums are those of its winches, whatever its cable model.
        unwound: (K, m) m, unwound lengths.
        rate: (K, m) m/s.
        acceleration: (K, m) m/s^2.

    Raises:
        CdprError: for numbers of a winch that contradict each other.
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> robot = cdpr.load_robot("caroca_winches")
        >>> home, still = home_lengths(robot), [[0.0] * 8]
        >>> drums = drum_motion(robot, [home - 0.1], still, still)
        >>> (drums.angle * drums.per_turn).round(9)[0, 0]
        np.float64(0.1)
    """
    given = [real(values, name) for values, name in ((unwound, "unwound"), (rate, "rate"))]
    given.append(real(acceleration, "acceleration"))
    found = [np.empty(given[0].shape) for _ in range(5)]
    names = "angle", "per_turn", "speed", "turning", "load"
    inputs = dict(zip(("unwound", "rate", "acceleration"), given, strict=True))
    bind("drum_motions", drums=drum_table(robot), **inputs, **dict(zip(names, found, strict=True)))()
    return DrumMotion(*found)


def unwound_lengths(robot: Robot, angles: ArrayLike) -> Array:
    """Return the unwound lengths at angles of the drums.

    Args:
        robot: the robot.
        angles: (K, m) rad, 0 at the home pose, positive after winding in.

    Returns:
        (K, m) m; NaN for cables without a drum, and beyond the end of the cable on a drum that grows.

    Raises:
        CdprError: for numbers of a winch that contradict each other.
        ValueError: if the shapes do not match.
    """
    angle = real(angles, "angles")
    unwound = np.empty(angle.shape)
    bind("drum_lengths", drums=drum_table(robot), angle=angle, unwound=unwound)()
    return unwound


def emptied(robot: Robot, lengths: Array) -> str:
    """Return a message on the first drum that is nearly empty with unwound lengths (m,) [m]; "" if none is."""
    found = first_emptied(robot, lengths[None])
    return "" if found is None else found[2]


def first_emptied(robot: Robot, lengths: Array) -> tuple[int, int, str] | None:
    """Return the first sample at which a drum is nearly empty, with the index of its cable and a message.

    Args:
        robot: the robot.
        lengths: (K, m) m, unwound lengths.
    """
    growth = np.array([GROWTH.of(cable, 0.0) for cable in robot.cables])
    if not (growth > 0.0).any():
        return None
    still = np.zeros(lengths.shape)
    least = [EMPTY * RADIUS.of(cable, math.nan) / REEVING.of(cable) for cable in robot.cables]
    empty = (growth > 0.0) & ~(drum_motion(robot, lengths, still, still).per_turn > least)
    if not empty.any():
        return None
    k, i = np.argwhere(empty)[0].tolist()
    text = (
        f"cable '{robot.cables[i].name}': its drum is empty at a length of {lengths[k, i]:.4g} m, as its radius "
        f"shrinks with {GROWTH.name}: expected a larger {RADIUS.name} at the home pose, or less growth"
    )
    return k, i, text


def drum_table(robot: Robot) -> Array:
    """Return the drums of a robot, (m, 7): radius [m] and the numbers of the transmission, see drums.hpp."""
    return np.array(
        [
            [
                math.nan if cable.winch is None else RADIUS.of(cable, math.nan),
                *transmission_numbers(cable, _accepted(robot, cable), robot.unilateral),
                home,
            ]
            for cable, home in zip(robot.cables, home_lengths(robot).tolist(), strict=True)
        ]
    )


def _accepted(robot: Robot, cable: Cable) -> Sequence[Number]:
    """Return the numbers of the transmission that the winch of a cable uses; all of a winch that does not turn."""
    winch = chain_of(robot, cable).winch
    if cable.winch is None:
        return ()
    return winch.transmission if winch.states else KERNEL
