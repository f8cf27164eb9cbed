"""Platforms on a spherical joint at their origin: spherical robots with the degrees of freedom rx, ry, rz.

The equation of motion is J w' + w x J w = M + c x m g (Euler's equations about a fixed point). J is the inertia about
the origin in body axes, w the angular velocity, c the centre of mass, and M the moment of the cables and the external
wrench about the origin. The joint takes any force.
"""

from __future__ import annotations

import numpy as np

from cdpr.model.robot import Array, Robot


def pack(robot: Robot) -> Array:
    """Return the arguments of the kernels (21,): m c (3), the inertia about the origin (9) and its inverse (9).

    All are in platform axes, row by row. The inertia is J_c + m (|c|^2 - c c^T) (Steiner). It is written out because
    exported FMUs perform the same operations.
    """
    mass, x, y, z = robot.inertial[:4].tolist()
    Jxx, Jxy, Jxz, _, Jyy, Jyz, _, _, Jzz = robot.inertial[4:].tolist()
    Jxx, Jyy, Jzz = Jxx + mass * (y * y + z * z), Jyy + mass * (x * x + z * z), Jzz + mass * (x * x + y * y)
    Jxy, Jxz, Jyz = Jxy - mass * (x * y), Jxz - mass * (x * z), Jyz - mass * (y * z)
    xx, xy, xz = Jyy * Jzz - Jyz * Jyz, Jxz * Jyz - Jxy * Jzz, Jxy * Jyz - Jxz * Jyy  # cofactors
    yy, yz, zz = Jxx * Jzz - Jxz * Jxz, Jxy * Jxz - Jxx * Jyz, Jxx * Jyy - Jxy * Jxy
    det = Jxx * xx + Jxy * xy + Jxz * xz
    inverse = np.array([xx, xy, xz, xy, yy, yz, xz, yz, zz]) / det
    return np.concatenate([[mass * x, mass * y, mass * z], [Jxx, Jxy, Jxz, Jxy, Jyy, Jyz, Jxz, Jyz, Jzz], inverse])
