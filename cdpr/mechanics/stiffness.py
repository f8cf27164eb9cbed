"""How stiffly cables hold a platform: elastic and geometric stiffness, natural frequencies, dexterity.

With the drums locked, a small motion (dp, dtheta) of the platform, world axes, about its origin, changes what acts on
it by -K (dp, dtheta). Three parts make K: the cables' elasticity, W diag((E A + t) / l) W^T, as E A / l0 = (E A + t) /
l; their tensions, whose directions turn, -(dW t), with the pulleys on which they swivel; and the weight, whose point of
attack moves. A cable that does not pull is slack, and no spring. K is symmetric where all that acts is in balance
(thesis, eq. 2.25 to 2.28, without its slips).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cdpr.cables.lines import lines
from cdpr.mechanics import geometry
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import STILL
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.jit import threaded_kernel
from cdpr.model.kernels import quaternion, rotate, vector
from cdpr.model.kinds import CUBE, NOTHING, ROW, TABLE, TRUTH, Group
from cdpr.model.robot import Array
from cdpr.model.threads import in_threads

# Share of the largest tension up to which a cable is slack: it is at its lower limit of 0, and resists nothing.
SLACK = 1e-9


class Held(NamedTuple):
    """A robot, held by its cables."""

    lines: Array  # (m, 6 or more), as `cdpr.cables.lines` says
    axial_stiffness: Array  # (m,), N; 0 of cables that give no resistance of their own
    inertial: Array  # (13,), as `Robot.inertial`
    gravity: Array  # (3,), m/s^2
    unilateral: bool  # whether cables that do not pull are slack, and no springs


class At(NamedTuple):
    """K poses."""

    poses: Array  # (K, 7)
    tension: Array  # (K, m), N
    stiffness: Array  # (K, 6, 6), N/m, N, N m
    W: Array  # (K, 6, m), wrench matrices


HELD, AT = Group((TABLE, ROW, ROW, ROW, TRUTH), Held), Group((TABLE, TABLE, CUBE, CUBE), At)


@threaded_kernel(NOTHING(HELD, AT))
def write(held: Held, at: At) -> None:
    """Write K and W at all poses."""
    m = held.lines.shape[0]
    state, rate, length, slower = np.zeros(13), np.empty((6, m)), np.empty(m), np.empty(m)
    for k in range(at.poses.shape[0]):
        K, W, tension = at.stiffness[k], at.W[k], at.tension[k]
        for i in range(7):
            state[i] = at.poses[k, i]
        geometry.cable_geometry(held.lines, state, W, length, slower)
        largest = 0.0
        for c in range(m):
            largest = max(largest, abs(tension[c]))
        for j in range(6):
            state[7 + j] = 1.0
            geometry.wrench_matrix_rate(held.lines, state, rate)
            state[7 + j] = 0.0
            for i in range(6):
                K[i, j] = 0.0
                for c in range(m):
                    taut = not held.unilateral or tension[c] > SLACK * largest
                    if taut and held.axial_stiffness[c] > 0.0:
                        K[i, j] += W[i, c] * W[j, c] * (held.axial_stiffness[c] + tension[c]) / length[c]
                    K[i, j] -= rate[i, c] * tension[c]
        arm = rotate(quaternion(state, 3), vector(held.inertial, 1))
        mass, g = held.inertial[0], held.gravity
        along = mass * (g[0] * arm[0] + g[1] * arm[1] + g[2] * arm[2])
        for i in range(3):
            for j in range(3):
                # Of the weight f at an arm c that turns: -d(c x f) = (c . f) dtheta - c (f . dtheta).
                K[3 + i, 3 + j] += (along if i == j else 0.0) - mass * arm[i] * g[j]


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
    held = Held(
        lines(robot).copy(),
        checked(np.broadcast_to(np.asarray(known, dtype=float), (robot.m,)), (robot.m,), "axial_stiffness").copy(),
        robot.inertial.copy(),
        checked(gravity, (3,), "gravity", finite=True).copy(),
        robot.unilateral,
    )
    count = len(given)
    pulled = checked(tension, (count, robot.m), "tension")
    at = At(given.copy(), pulled.copy(), np.empty((count, 6, 6)), np.empty((count, 6, robot.m)))
    in_threads(count, lambda cut: write(held, At(*(each[cut] for each in at))), jobs)
    return at.stiffness, at.W


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
