"""Platforms that a ball holds at their origin, about which they turn freely: spherical robots, dof rx, ry, rz.

With J the inertia about the origin, body axes, w the angular velocity there, c the centre of mass and M the moment of
cables and external wrench about the origin: J w' + w x J w = M + c x m g (Euler's equations about a fixed point). The
ball takes whatever force comes.
"""

from __future__ import annotations

import numpy as np

from cdpr.model.robot import Array, Robot


def pack(robot: Robot) -> Array:
    """Pack for the kernels, (21,): mass times centre of mass (3), inertia about the origin (9), its inverse (9).

    Platform axes, row by row. The inertia is J_c + m (|c|^2 - c c^T) (Steiner). Written out, for exported FMUs do the
    same operations.
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
