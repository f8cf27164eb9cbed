"""Capacity margin, wrench closure and payload at many poses, on all cores."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.analysis.distribution.distributions import check_unit
from cdpr.analysis.workspace.required import FORMS, NOTHING, Required
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.base.threads import in_threads
from cdpr.cables.tables import line_table
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.scenario.loader import AnyRobot, robot_of

Mode = Literal["margin", "closure", "payload"]

CHUNK = 8192  # poses per thread and task: some milliseconds

# Status of a pose, as in assess.hpp.
REGULAR, LACKS_RANK, NOT_FINITE = range(3)


class PoseQuestion(NamedTuple):
    """Arguments of the operations `assess` and `prove` (assess.hpp) that are common to all poses.

    Attributes:
        lines: (m, w), as in `cdpr.cables.tables.line_table`.
        tension_min: (m,) N.
        tension_max: (m,) N.
        rows: (n,), rows of a wrench for the degrees of freedom.
        weights: (n,), 1 for forces, 1 / characteristic length for moments, 1/m.
        inertial: (13,), as in `Robot.inertial`.
        gravity: (3,) m/s^2, world axes.
        vectors: (k, 6), vectors of the required set: N and N m, or m/s^2 and rad/s^2.
        mode: 0 margin, 1 closure, 2 payload.
        form: form of the required set, a value of `cdpr.analysis.workspace.required.FORMS`.
        accelerations: True if the vectors are accelerations.
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
    """Results of K poses.

    Attributes:
        value: (K,), signed, >= 0 inside: capacity margin, N, moments divided by the characteristic length; for closure
            the smaller side of the least elementary vector; payload, kg in addition to the platform. NaN if W is
            rank-deficient, and for the payload if the platform itself is too light.
        scale: (K,), magnitude of the terms whose difference is the value: below `MARGIN_ROUNDING` (facets.hpp) times
            the scale, the sign is round-off.
        singular: (K,), True if W is rank-deficient, so that the cables exert nothing in some direction.
        limit: (K,), number of the named limit of the value; -1 if none.
        direction: (K, n), unit wrench, moments divided by that length, of the smallest margin; only for margins.
    """

    value: Array
    scale: Array
    singular: NDArray[np.bool_]
    limit: NDArray[np.int64]
    direction: Array | None = None


def measure(
    robot: AnyRobot,
    poses: ArrayLike,
    mode: Mode = "margin",
    required: Required = NOTHING,
    *,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
    length: float | None = None,
    jobs: int | None = None,
) -> Measured:
    """Return a measure of the cables' capacity at poses (K, 7), position (m) and quaternion w, x, y, z.

    Args:
        robot: geometry, limits, mass and degrees of freedom: a Robot, a file, an example's name, a dict or a Scenario.
        poses: poses of the platform's origin.
        mode: "margin", the signed distance from the required set to the nearest facet of the available wrenches
            (Gouttefarde and Krut, ARK 2010); "closure", the ability to pull against each other in all directions;
            "payload", the largest mass at the platform's centre of mass, in addition to its own, with a margin of 0.
        required: wrenches required in addition to the weight at rest.
        gravity: (3,), m/s^2, world.
        length: divisor of moments, m; the robot's characteristic length by default.
        jobs: threads, one per core by default; the result is the same.

    Raises:
        CdprError: if an argument has the wrong type or shape, or lower limits are infinite or above the upper ones.
    """
    given = np.ascontiguousarray(checked(poses, (None, 7), "poses", finite=True))
    check_unit(given, "poses")
    robot = robot_of(robot)
    question, count = pose_question(robot, mode, required, gravity, length)._asdict(), len(given)
    value, scale, direction = np.empty(count), np.empty(count), np.empty((count, robot.n))
    status, limit = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)

    def part(cut: slice) -> None:
        bind(
            "assess",
            **question,
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
        raise CdprError("required: too large, the margins overflow")
    return Measured(value, scale, status == LACKS_RANK, limit, direction)


def pose_question(
    robot: Robot, mode: Mode, required: Required, gravity: ArrayLike, length: float | None
) -> PoseQuestion:
    """Return the arguments of `measure` for the kernels.

    Raises:
        CdprError: if an argument is invalid.
    """
    if mode not in get_args(Mode):
        raise CdprError(f"mode: expected one of {', '.join(get_args(Mode))}, got {shown(mode)}")
    if length is not None and not 0.0 < length < math.inf:
        raise CdprError(f"length: expected a length above 0 m, got {shown(length)}")
    low, high = robot.tension_min, robot.tension_max
    if mode == "closure":  # stronger cables can exceed their limits
        low, high = np.zeros(robot.m), np.ones(robot.m)
    if not np.isfinite([low, high]).all():
        raise CdprError("robot: a workspace requires finite limits of all tensions: give tension_max")
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
