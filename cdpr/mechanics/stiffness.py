"""How stiffly cables hold a platform: elastic and geometric stiffness, natural frequencies, dexterity.

With the drums locked, a small motion (dp, dtheta) of the platform, world axes, about its origin, changes what acts on
it by -K (dp, dtheta). Three parts make K: the cables' elasticity, W diag((E A + t) / l) W^T, as E A / l0 = (E A + t) /
l; their tensions, whose directions turn, -(dW t), with the pulleys on which they swivel; and the weight, whose point of
attack moves. A cable that does not pull is slack, and no spring. K is symmetric where all that acts is in balance
(thesis, eq. 2.25 to 2.28, without its slips).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.cables.tables import line_table
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import STILL
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.model.threads import in_threads
from cdpr.native.bind import bind

# Share of the largest tension up to which a cable is slack: it is at its lower limit of 0, and resists nothing.
SLACK = 1e-9


def stiffness(
    robot: Robot,
    poses: ArrayLike,
    tension: ArrayLike,
    *,
    axial_stiffness: ArrayLike | None = None,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
    jobs: int | None = None,
) -> tuple[Array, Array]:
    """Return stiffness matrices (K, 6, 6), N/m, N and N m, and wrench matrices (K, 6, m).

    Args:
        robot: gives geometry, mass and the cables' axial stiffness.
        poses: (K, 7), position (m) and quaternion w, x, y, z.
        tension: (K, m), N.
        axial_stiffness: E A of the cables, N, one or (m,); their own unless given, none where that is not known.
        gravity: (3,), m/s^2, world.
        jobs: threads; the result is the same.

    Raises CdprError where an argument is of the wrong kind or shape.
    """
    given = checked(poses, (None, 7), "poses", finite=True)
    known = [cable.axial_stiffness or 0.0 for cable in robot.cables] if axial_stiffness is None else axial_stiffness
    elastic = np.broadcast_to(np.asarray(known, dtype=float), (robot.m,))
    fixed = {
        "lines": line_table(robot),
        "axial_stiffness": checked(elastic, (robot.m,), "axial_stiffness"),
        "inertial": robot.inertial,
        "gravity": checked(gravity, (3,), "gravity", finite=True),
        "unilateral": int(robot.unilateral),
    }
    count = len(given)
    pulled = checked(tension, (count, robot.m), "tension")
    found, matrices = np.empty((count, 6, 6)), np.empty((count, 6, robot.m))

    def write(cut: slice) -> None:
        at = {"poses": given[cut], "tension": pulled[cut], "stiffness": found[cut], "matrices": matrices[cut]}
        bind("stiffness", **fixed, **at).unlocked()

    in_threads(count, write, jobs)
    return found, matrices


def inertia(robot: Robot, poses: ArrayLike) -> Array:
    """Return the platform's inertia (K, 6, 6) about its origin at poses (K, 7), kg, kg m, kg m^2, world axes."""
    given = checked(poses, (None, 7), "poses", finite=True)
    mass = np.empty((len(given), 6, 6))
    state = np.zeros(13)
    for k, pose in enumerate(given):
        state[:7] = pose
        for j, e in enumerate(np.eye(6)):
            mass[k, :, j] = required_wrench(robot, state, STILL, e[:3], e[3:])
    return mass
