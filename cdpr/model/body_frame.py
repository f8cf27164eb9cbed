"""The frame in which rigid bodies are integrated: at the centre of mass, along the principal axes.

There the inertia is diagonal and the centre of mass moves by the force alone, so that every engine gets the same
simple body whatever the robot's mass distribution.
"""

from __future__ import annotations

import numpy as np

from cdpr.model import rotations
from cdpr.model.jit import kernel
from cdpr.model.kernels import (
    Quaternion,
    Vector,
    cable_wrench,
    conjugate,
    cross,
    multiply,
    quaternion,
    rotate,
    store,
    vector,
)
from cdpr.model.robot import Array, Robot

# Off-diagonal entries below this share of the trace are round-off of the input: the tensor counts as diagonal and the
# axes stay where they are.
DIAGONAL = 1e-14


class BodyFrame:
    """A robot's platform seen from its centre of mass and principal axes.

    A body state (13,) is laid out like a platform state, with the centre of mass in place of the origin and the
    attitude of the principal axes in place of the platform's.

    Attributes:
        mass: kg.
        moments: (3,) principal moments of inertia, kg m^2.
        anchors: (m, 6) anchors A_i in the world and B_i in the body frame, m.
        offset: (7,) from the platform's origin to the centre of mass in body axes (3), m, and the attitude of the
            principal axes in the platform, w, x, y, z (4).
    """

    def __init__(self, robot: Robot) -> None:
        platform = robot.platform
        inertia = platform.inertia
        off_diagonal = inertia - np.diag(np.diag(inertia))
        if np.abs(off_diagonal).max() <= DIAGONAL * np.trace(inertia):
            self.moments, axes = np.diag(inertia).copy(), np.eye(3)
        else:
            self.moments, axes = np.linalg.eigh(inertia)
            axes[:, 0] *= np.linalg.det(axes)  # eigenvectors may be left-handed
        self.mass = platform.mass
        self.anchors = robot.anchors.copy()
        self.anchors[:, 3:] = (robot.anchors[:, 3:] - platform.center_of_mass) @ axes
        self.offset = np.concatenate([axes.T @ platform.center_of_mass, rotations.from_matrix(axes)])


@kernel
def from_platform(offset: Array, state: Array, body: Array) -> None:
    """Write the body state (13,) of a platform state (13,)."""
    attitude = multiply(quaternion(state, 3), quaternion(offset, 3))
    r = rotate(attitude, vector(offset, 0))
    swing = cross(vector(state, 10), r)
    for i in range(3):
        body[i] = state[i] + r[i]
        body[7 + i] = state[7 + i] + swing[i]
        body[10 + i] = state[10 + i]
    for i in range(4):
        body[3 + i] = attitude[i]


@kernel
def to_platform(offset: Array, body: Array, state: Array) -> None:
    """Write the platform state (13,) of a body state (13,)."""
    attitude = quaternion(body, 3)
    r = rotate(attitude, vector(offset, 0))
    swing = cross(vector(body, 10), r)
    q = multiply(attitude, conjugate(quaternion(offset, 3)))
    for i in range(3):
        state[i] = body[i] - r[i]
        state[7 + i] = body[7 + i] - swing[i]
        state[10 + i] = body[10 + i]
    for i in range(4):
        state[3 + i] = q[i]


@kernel
def body_wrench(
    anchors: Array, offset: Array, tension: Array, external: Array, p: Vector, q: Quaternion
) -> tuple[Vector, Vector]:
    """Force and moment about the centre of mass, world axes, of cables and external wrench on a body at p, q.

    `external` (6,) acts at the platform's origin, which lies at -r from the centre of mass.
    """
    f, moment = cable_wrench(anchors, p, q, tension)
    push = vector(external, 0)
    lever = cross(rotate(q, vector(offset, 0)), push)
    return (f[0] + push[0], f[1] + push[1], f[2] + push[2]), (
        moment[0] + external[3] - lever[0],
        moment[1] + external[4] - lever[1],
        moment[2] + external[5] - lever[2],
    )


@kernel
def applied_wrench(anchors: Array, offset: Array, tension: Array, external: Array, body: Array, applied: Array) -> None:
    """Write `body_wrench` at a body state (13,) into `applied` (6,)."""
    f, moment = body_wrench(anchors, offset, tension, external, vector(body, 0), quaternion(body, 3))
    store(f, applied, 0)
    store(moment, applied, 3)
