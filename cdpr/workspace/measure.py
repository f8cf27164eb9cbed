"""Capacity margins, wrench closure and payload at many poses, on all cores."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.cables.tables import line_table
from cdpr.distribution.distributions import check_robot, check_unit
from cdpr.errors import CdprError
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.model.threads import in_threads
from cdpr.native.bind import bind
from cdpr.workspace.required import FORMS, NOTHING, Required

Mode = Literal["margin", "closure", "payload"]

CHUNK = 8192  # poses that a thread takes at a time: some milliseconds

# Answers about a pose, as in assess.hpp.
REGULAR, LACKS_RANK, NOT_FINITE = range(3)


class PoseQuestion(NamedTuple):
    """The question about all poses, as arguments of the operations `assess` and `prove` (assess.hpp).

    Attributes:
        lines: (m, w), as of `cdpr.cables.tables.line_table`.
        tension_min: (m,) N.
        tension_max: (m,) N.
        rows: (n,), degrees of freedom: rows of a wrench.
        weights: (n,), 1, and of moments 1 / characteristic length, 1/m.
        inertial: (13,), as of `Robot.inertial`.
        gravity: (3,) m/s^2, world axes.
        vectors: (k, 6), of the required set: N and N m, or m/s^2 and rad/s^2.
        mode: 0 margin, 1 closure, 2 payload.
        form: Of the required set, a value of `cdpr.workspace.required.FORMS`.
        accelerations: Whether the vectors are such.
    """

    lines: Array
    tension_min: Array
    tension_max: Array
    rows: NDArray[np.int64]
    weights: Array
    inertial: Array
    gravity: Array
    vectors: Array
    mode: int
    form: int
    accelerations: bool


@dataclass(frozen=True, eq=False)
class Measured:
    """What was found of K poses.

    Attributes:
        value: (K,), signed, >= 0 inside: capacity margin, N, moments divided by the characteristic length; of closure
            the smaller side of the least elementary vector; payload, kg beside the platform. NaN where W lacks rank,
            and of the payload where the platform itself is too light.
        scale: (K,), of the numbers that the value is a difference of: below `MARGIN_ROUNDING` (facets.hpp) times that
            its sign is round-off.
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
    given = np.ascontiguousarray(checked(poses, (None, 7), "poses", finite=True))
    check_unit(given, "poses")
    asked, count = asked_of(robot, mode, required, gravity, length)._asdict(), len(given)
    value, scale, direction = np.empty(count), np.empty(count), np.empty((count, robot.n))
    status, limit = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)

    def part(cut: slice) -> None:
        bind(
            "assess",
            **asked,
            poses=given[cut],
            value=value[cut],
            scale=scale[cut],
            direction=direction[cut],
            status=status[cut],
            limit=limit[cut],
        ).unlocked()

    in_threads(count, part, jobs, CHUNK)
    if (status == NOT_FINITE).any():
        raise CdprError(f"poses[{int(np.argmax(status == NOT_FINITE))}]: an anchor lies on the other of its cable")
    if mode != "payload" and not np.isfinite(scale).all():
        raise CdprError("required: is beyond what numbers hold, and so are the margins")
    return Measured(value, scale, status == LACKS_RANK, limit, direction)


def asked_of(robot: Robot, mode: Mode, required: Required, gravity: ArrayLike, length: float | None) -> PoseQuestion:
    """Return the question of `measure` for the kernels. Raises CdprError, likewise."""
    check_robot(robot)
    if mode not in get_args(Mode):
        raise CdprError(f"mode: one of {', '.join(get_args(Mode))} is expected, got {mode!r}")
    if length is not None and not 0.0 < length < math.inf:
        raise CdprError(f"length: a length above 0 m is expected, got {length!r}")
    low, high = robot.tension_min, robot.tension_max
    if not np.isfinite([low, high]).all():
        raise CdprError("robot: a workspace needs finite limits of all tensions")
    if mode == "closure":  # strong enough cables can do more than their limits let them
        low, high = np.zeros(robot.m), np.ones(robot.m)
    arm = robot.characteristic_length if length is None else float(length)
    return PoseQuestion(
        lines=line_table(robot),
        tension_min=np.ascontiguousarray(low, dtype=np.float64),
        tension_max=np.ascontiguousarray(high, dtype=np.float64),
        rows=np.array(robot.rows, dtype=np.int64),
        weights=np.repeat([1.0, 1.0 / arm], 3)[robot.rows],
        inertial=robot.inertial,
        gravity=np.ascontiguousarray(checked(gravity, (3,), "gravity", finite=True)),
        vectors=np.ascontiguousarray(required.vectors, dtype=np.float64),
        mode=get_args(Mode).index(mode),
        form=FORMS[required.form],
        accelerations=required.accelerations,
    )
