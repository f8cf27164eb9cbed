"""Cables that sag: their least tensions and their curves at poses of a robot."""

from __future__ import annotations

import numpy as np

from cdpr.cables import chain_of
from cdpr.cables.catenary.curve import least_tension
from cdpr.cables.tables import chain_table, exits, line_table
from cdpr.mechanics.curves import cable_curves
from cdpr.model import Robot, rotations
from cdpr.model.robot import Array
from cdpr.native.bind import bind

# Quantities with and without sag, for output and documentation.
CHORD = (
    "equilibria, stiffness, frequencies, and clearances of runs, poses and motions include it; static tensions, "
    "capacities, dexterity, sizing, forward kinematics and clearances of workspaces use the chords, without weight"
)
STRAIGHT = "Cables that sag are drawn as straight lines, because their lengths are unknown."
SIZED = "cables sag: lengths are those of the chords, and tensions that are not of a run leave out the cables' weight"


def sagging(robot: Robot) -> list[int]:
    """Return the indices of the cables that sag."""
    return [i for i, cable in enumerate(robot.cables) if chain_of(robot, cable).span.bends]


def least_tensions(robot: Robot, position: Array, orientation: Array, gravity: Array) -> Array:
    """Return the least tensions of the cables at their winches.

    A heavy cable with less tension has no equilibrium (`cdpr.cables.catenary`).

    Args:
        robot: the robot.
        position: (k, 3) m, of the platform's origin.
        orientation: (k, 4) quaternions w, x, y, z.
        gravity: (3,) m/s^2, world axes.

    Returns:
        (k, m) N, 0 for cables that do not sag. The part of a cable on its pulley is left out.
    """
    found, some = np.zeros((len(position), robot.m)), sagging(robot)
    if not some:
        return found
    tips, leaving = _ends(robot, position, orientation)
    cables = [robot.cables[i] for i in some]
    density = np.array([cable.linear_density or 0.0 for cable in cables])
    stiffness = np.array([cable.axial_stiffness for cable in cables], dtype=np.float64)
    weight = density * float(np.linalg.norm(gravity))
    found[:, some] = least_tension(leaving[:, some] - tips[:, some], weight, stiffness, gravity)
    return found


def too_loose(robot: Robot, position: Array, orientation: Array, gravity: Array, tension: Array) -> str:
    """Return which cables have less than their least tension at a pose, and the remedy; "" if none.

    Args:
        robot: the robot.
        position: (3,) m.
        orientation: (4,) quaternion w, x, y, z.
        gravity: (3,) m/s^2.
        tension: (m,) N, at the winches.
    """
    if not sagging(robot):
        return ""
    least = least_tensions(robot, position[None], orientation[None], gravity)[0]
    short = np.flatnonzero(~(tension >= least))
    if not len(short):
        return ""
    i = int(short[np.argmax(least[short])])
    more = f" (and {len(short) - 1} more)" if len(short) > 1 else ""
    return (
        f"cable '{robot.cables[i].name}'{more}: {tension[i]:.4g} N cannot carry its weight: it needs at least "
        f"{least[i]:.4g} N at its winch here; raise tension.min, or give less linear_density"
    )


def curves(
    robot: Robot, position: Array, orientation: Array, unstretched: Array, gravity: Array, count: int
) -> dict[int, Array]:
    """Return the curves of the cables that sag, by their indices.

    Args:
        robot: the robot.
        position: (3,) m.
        orientation: (4,) quaternion w, x, y, z.
        unstretched: (m,) m, unstretched lengths between winch and platform.
        gravity: (3,) m/s^2.
        count: points of a curve.

    Returns:
        (count, 3) m each, world frame, from the platform to the exit at equal unstretched lengths. Straight if there is
            no equilibrium.
    """
    pose, lengths = np.concatenate([position, orientation])[None], np.asarray(unstretched)[None]
    (found,) = cable_curves(line_table(robot), chain_table(robot), gravity, pose, lengths, count)
    return {i: found[i, ::-1] for i in sagging(robot)}


def sagging_wrench(robot: Robot, poses: Array, tension: Array, gravity: Array) -> Array:
    """Return the wrenches of cables that sag minus those of their tensions along their chords.

    Args:
        robot: the robot.
        poses: (k, 7) positions [m] and quaternions w, x, y, z.
        tension: (k, m) tensions of taut cables at their winches [N].
        gravity: (3,) m/s^2, world axes.

    Returns:
        (k, 6) N and N m at the platform's origin, world axes; NaN for tensions below the least ones.
    """
    found = np.empty((len(poses), 6))
    fixed = {"lines": line_table(robot), "chains": chain_table(robot), "gravity": gravity}
    bind("sagging_wrench", **fixed, poses=poses, tension=tension, wrench=found)()
    return found


def _ends(robot: Robot, position: Array, orientation: Array) -> tuple[Array, Array]:
    """Return anchors on the platform and exit points, (k, m, 3) m."""
    k, m = len(position), robot.m
    turned = np.asarray(rotations.matrix(np.asarray(orientation, dtype=np.float64)))
    tips = np.asarray(position)[:, None] + robot.anchors[:, 3:] @ np.swapaxes(turned, -1, -2)
    points, _, _ = exits(np.tile(line_table(robot), (k, 1)), tips.reshape(-1, 3))
    return tips, points.reshape(k, m, 3)
