"""Elastic and geometric stiffness of a platform on cables, and its inertia.

With locked drums, a small motion (dp, dtheta) of the platform about its origin, in world axes, changes the wrench on it
by -K (dp, dtheta). K is the sum of three parts. The elasticity of the cables gives W diag((E A + t) / l) W^T, because
E A / l0 = (E A + t) / l. The change of the directions of the tensions gives -(dW t), including the swivelling pulleys.
The third part is the shift of the centre of mass, where the weight acts. A cable without tension is slack and adds no
stiffness. K is symmetric if all wrenches are in balance (thesis, eq. 2.25 to 2.28, with its errors corrected).

A cable that sags has the stiffness of its catenary instead, the derivative of its wrench at constant unwound length:
its tension at the winch is the given one, and it is taut. Its mass is not part of the inertia.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.threads import in_threads
from cdpr.cables import chain_of
from cdpr.cables.tables import chain_table, line_table
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import STILL
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.native.bind import bind

# Share of the largest tension up to which a cable is slack: it is at its lower limit of 0 and has no stiffness.
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
    """Return the stiffness matrices (K, 6, 6) [N/m, N, N m] and the wrench matrices (K, 6, m).

    Args:
        robot: robot with the geometry, the mass and the axial stiffness of the cables.
        poses: (K, 7) positions [m] and quaternions w, x, y, z.
        tension: (K, m) tensions, of cables that sag at their winches [N]. With less than the least tension of such a
            cable, the stiffness is NaN.
        axial_stiffness: E A of the cables [N], one value or (m,). By default, it is their own, that of the curve at the
            given tension, or 0 if it is not known.
        gravity: (3,) gravity [m/s^2], in world axes.
        jobs: number of threads. It does not change the result.

    Raises:
        CdprError: if an argument has the wrong kind or shape.
    """
    given = checked(poses, (None, 7), "poses", finite=True)
    count = len(given)
    pulled = checked(tension, (count, robot.m), "tension")
    spans = [chain_of(robot, cable).span for cable in robot.cables]
    if axial_stiffness is None:
        tangents = [span.tangent(cable, t) for span, cable, t in zip(spans, robot.cables, pulled.T, strict=True)]
        elastic = np.stack(tangents, axis=-1)
    else:
        one = np.broadcast_to(np.asarray(axial_stiffness, dtype=float), (robot.m,))
        elastic = np.tile(checked(one, (robot.m,), "axial_stiffness"), (count, 1))
    fixed: dict[str, Any] = {
        "lines": line_table(robot),
        "inertial": robot.inertial,
        "gravity": checked(gravity, (3,), "gravity", finite=True),
        "unilateral": int(robot.unilateral),
    }
    found, matrices = np.empty((count, 6, 6)), np.empty((count, 6, robot.m))
    bent = [span.bends for span in spans]
    chordal = np.where(bent, 0.0, pulled)

    def write(cut: slice) -> None:
        at = {"poses": given[cut], "tension": chordal[cut], "stiffness": found[cut], "matrices": matrices[cut]}
        bind("stiffness", **fixed, **at, axial_stiffness=elastic[cut.start].copy()).unlocked()

    if (elastic == elastic[:1]).all():
        in_threads(count, write, jobs)
    else:  # of a curve
        for k in range(count):
            write(slice(k, k + 1))
    if any(bent) and count:
        _add_sagging(robot, given, pulled, found, elastic[0], fixed["gravity"], jobs)
    return found, matrices


def _add_sagging(
    robot: Robot, poses: Array, tension: Array, found: Array, elastic: Array, gravity: Array, jobs: int | None
) -> None:
    """Add the stiffness of the cables that sag to matrices (K, 6, 6)."""
    cables = [
        replace(cable, axial_stiffness=value) for cable, value in zip(robot.cables, elastic.tolist(), strict=True)
    ]
    fixed = {"lines": line_table(robot), "chains": chain_table(robot.replace(cables=cables)), "gravity": gravity}

    def write(cut: slice) -> None:
        at = {"poses": poses[cut], "tension": tension[cut], "stiffness": found[cut]}
        bind("sagging_stiffness", **fixed, **at).unlocked()

    in_threads(len(poses), write, jobs)


def inertia(robot: Robot, poses: ArrayLike) -> Array:
    """Return the inertia (K, 6, 6) of the platform about its origin at poses (K, 7) [kg, kg m, kg m^2], world axes."""
    given = checked(poses, (None, 7), "poses", finite=True)
    mass = np.empty((len(given), 6, 6))
    state = np.zeros(13)
    for k, pose in enumerate(given):
        state[:7] = pose
        for j, e in enumerate(np.eye(6)):
            mass[k, :, j] = required_wrench(robot, state, STILL, e[:3], e[3:])
    return mass
