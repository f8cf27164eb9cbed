"""Stretch of cables in an extended Kalman filter.

The filter simulates the drums of winches that take tensions, with their inertia and friction. So the tension lags
behind its command as that of the plant does. Errors of the estimate are assumed to move the drums at once, as the drums
vibrate faster than the estimate changes; so the covariance has no states of the drums.

With load cells, the stretch follows from the measured tension T: d s' = T - T(s), with the damping d of the cable. The
stretch of cables that creep is that at rest.
"""

from __future__ import annotations

import numpy as np

from cdpr.cables import chain_of
from cdpr.mechanics.kinematics import lengths, wrench_matrix
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.model.robot import Array

# Largest frequency of the platform on its cables times the control period, at which the explicit steps of platform and
# drums, one after the other, are accurate; they are stable below 2.
LARGEST_STEP = 1.0


def inverse_mass_matrix(inertial: Array) -> Array:
    """Return the inverse mass matrix about the platform's origin, platform axes.

    Args:
        inertial: (13,), `Robot.inertial`.

    Returns:
        (6, 6), SI units.
    """
    mass, c, inertia = inertial[0], inertial[1:4], inertial[4:].reshape(3, 3)
    lever = np.cross(np.eye(3), c)  # lever @ x = c x x
    matrix = np.block([[mass * np.eye(3), -mass * lever], [mass * lever, inertia - mass * lever @ lever]])
    inverse = np.linalg.inv(matrix)
    return np.asarray(0.5 * (inverse + inverse.T))


def drums_are_resolved(robot: Robot, step: float) -> bool:
    """Return whether the filter can simulate the drums of a robot whose winches take tensions.

    Otherwise it assumes that they follow their cables at once.

    Args:
        robot: nominal robot.
        step: control period, s.
    """
    rigidities = [
        chain_of(robot, cable).span.stiffest(cable) if chain_of(robot, cable).stretches else 0.0
        for cable in robot.cables
    ]
    if not any(rigidities):
        return False
    pose = home_pose(robot)[0]
    state = np.concatenate([pose, np.zeros(6)])
    W = wrench_matrix(robot, state)
    inverse = inverse_mass_matrix(robot.inertial)  # at the home pose, nearly in axes of the world
    K = W * (np.array(rigidities) / lengths(robot, state)) @ W.T
    rows = robot.rows
    squares = np.linalg.eigvals(inverse[np.ix_(rows, rows)] @ K[np.ix_(rows, rows)]).real
    return bool(step * np.sqrt(squares.max()) <= LARGEST_STEP)
