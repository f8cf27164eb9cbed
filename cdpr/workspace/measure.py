"""What the cables of a robot can do at many poses: arrays in, arrays out, on all cores."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.cables.lines import lines
from cdpr.distribution.distributions import check_robot, check_unit
from cdpr.errors import CdprError
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.model.threads import in_threads
from cdpr.workspace.required import FORMS, NOTHING, Required

if TYPE_CHECKING:
    from cdpr.workspace import assess

Mode = Literal["margin", "closure", "payload"]

CHUNK = 8192  # poses that a thread takes at a time: some milliseconds
MANY = 64  # poses: from here on eight at a time, which take a kernel more to load


@dataclass(frozen=True, eq=False)
class Measured:
    """What was found of K poses.

    Attributes:
        value: (K,), signed, >= 0 inside: capacity margin, N, moments divided by the characteristic length; of closure
            the smaller side of the least elementary vector; payload, kg beside the platform. NaN where W lacks rank,
            and of the payload where the platform itself is too light.
        scale: (K,), of the numbers that the value is a difference of: below `cdpr.workspace.assess.ROUNDING` times
            that its sign is round-off.
        singular: (K,), whether W lacks rank, so that the cables exert nothing in some direction.
        limit: (K,), what limits the value, a number for which there is a name; -1 of nothing.
        direction: (K, n), the unit wrench, moments divided by that length, in which the margin is least; of a margin
            alone.
    """

    value: Array
    scale: Array
    singular: NDArray[np.bool_]
    limit: NDArray[np.int64]
    direction: Array | None = None


def measure(
    robot: Robot,
    poses: ArrayLike,
    mode: Mode = "margin",
    required: Required = NOTHING,
    *,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
    length: float | None = None,
    jobs: int | None = None,
) -> Measured:
    """Measure what the cables can do at poses (K, 7), position (m) and quaternion w, x, y, z.

    Args:
        robot: gives geometry, limits, mass and degrees of freedom.
        poses: of the platform's origin.
        mode: "margin", the signed distance from the required set to the nearest facet of what the cables can exert
            (Gouttefarde and Krut, ARK 2010); "closure", whether they can pull against each other in all directions;
            "payload", the largest mass at the platform's centre of mass, beside its own, with a margin of 0.
        required: wrenches that must be exerted beyond carrying the weight at rest.
        gravity: (3,), m/s^2, world.
        length: by which moments are divided, m; the robot's characteristic length unless given.
        jobs: threads, one for each core unless given; the result is the same.

    Raises CdprError where an argument is of the wrong kind or shape, and where lower limits are infinite or above the
    upper ones.
    """
    from cdpr.workspace import assess, eights

    given = checked(poses, (None, 7), "poses", finite=True)
    check_unit(given, "poses")
    asked, n = asked_of(robot, mode, required, gravity, length), robot.n
    count = len(given)
    status, limit = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    found = assess.Found(given, np.empty(count), np.empty(count), np.empty((count, n)), status, limit)
    beside = count >= MANY and eights.eights_serve(asked)

    def part(cut: slice) -> None:
        values, scales, directions = found.value[cut], found.scale[cut], found.direction[cut]
        these = assess.Found(found.poses[cut], values, scales, directions, status[cut], limit[cut])
        if beside:
            eights.assess_eights(asked, these, assess.space_for(asked), eights.eight_for(asked))
        else:
            assess.assess(asked, these, assess.space_for(asked))

    in_threads(count, part, jobs, CHUNK)
    if (found.status == assess.BAD).any():
        raise CdprError(
            f"poses[{int(np.argmax(found.status == assess.BAD))}]: an anchor lies on the other of its cable"
        )
    if mode != "payload" and not np.isfinite(found.scale).all():
        raise CdprError("required: is beyond what numbers hold, and so are the margins")
    return Measured(found.value, found.scale, found.status == assess.SINGULAR, limit, found.direction)


def asked_of(robot: Robot, mode: Mode, required: Required, gravity: ArrayLike, length: float | None) -> assess.Asked:
    """Return what `measure` asks as kernels have it. Raises CdprError, likewise."""
    from cdpr.workspace import assess

    check_robot(robot)
    if mode not in get_args(Mode):
        raise CdprError(f"mode: one of {', '.join(get_args(Mode))} is expected, got {mode!r}")
    if length is not None and not 0.0 < length < math.inf:
        raise CdprError(f"length: a length above 0 m is expected, got {length!r}")
    limits = np.array([robot.tension_min, robot.tension_max])
    if not np.isfinite(limits).all():
        raise CdprError("robot: a workspace needs finite limits of all tensions")
    if mode == "closure":  # strong enough cables can do more than their limits let them
        limits = np.array([np.zeros(robot.m), np.ones(robot.m)])
    arm = robot.characteristic_length if length is None else float(length)
    return assess.Asked(
        mode=get_args(Mode).index(mode),
        lines=lines(robot).copy(),
        limits=limits,
        rows=np.array(robot.rows),
        weights=np.repeat([1.0, 1.0 / arm], 3)[robot.rows],
        inertial=robot.inertial.copy(),
        gravity=checked(gravity, (3,), "gravity", finite=True),
        form=FORMS[required.form],
        vectors=required.vectors.copy(),
        accelerations=required.accelerations,
        nothing=np.zeros(3),
    )
