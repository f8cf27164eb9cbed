"""The scheme of the engines, written out: semi-implicit Euler, first order, the cables evaluated once a step.

`cdpr compare` runs it beside an engine that declares this scheme: what differs is then the engine's adapter, not the
size of the step.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from cdpr.mechanics.guide import guided_acceleration, write_pose
from cdpr.mechanics.spherical import INERTIA, INVERSE, moment_about_ball, pack
from cdpr.model.jit import kernel
from cdpr.model.kernels import (
    Quaternion,
    Vector,
    conjugate,
    cross,
    exponential,
    multiply,
    product,
    quaternion,
    rotate,
    store,
    vector,
)
from cdpr.model.robot import Array
from cdpr.plugins import RigidBodyBackend
from cdpr.plugins.snapshots import SnapshotOfArrays
from cdpr_backends.attitude import put_attitude


class SemiImplicitEuler(SnapshotOfArrays, RigidBodyBackend):
    """First the velocities from the accelerations at the start of the step, then the pose from these velocities."""

    def build(self) -> None:
        """Bind the kernel for a free or a guided platform."""
        frame = self.frame
        self._motion = np.zeros(8)  # with a guide: position, angle, velocity, spin
        if frame.guide is None:
            inertial = np.array([frame.mass, *frame.moments])
            self._advance = partial(free_step, inertial, self.gravity, self.applied, self.body, self.physics_step)
        elif frame.guide.spherical:
            packed = pack(self.robot)
            self._advance = partial(spherical_step, packed, self.gravity, self.applied, self.body, self.physics_step)
        else:
            self._advance = partial(
                guided_step,
                frame.guide.packed,
                self.robot.inertial,
                self.gravity,
                self.applied,
                self._motion,
                self.body,
                self.physics_step,
            )

    def write(self) -> None:
        """Take the motion from `body`."""
        guide = self.frame.guide
        if guide is not None and guide.spherical:
            self.body[7:10] = 0.0
        elif guide is not None:
            free, axis = guide.packed[:3], guide.packed[3:]
            self._motion[:3], self._motion[3] = self.body[:3], guide.angle(self.body)
            self._motion[4:7], self._motion[7] = free * self.body[7:10], axis @ self.body[10:]

    def read(self) -> None:
        """The motion is in `body` already."""

    def advance(self) -> None:
        """Advance by one physics step."""
        self._advance()

    @property
    def arrays(self) -> tuple[Array, ...]:
        """What a snapshot must hold."""
        return *super().arrays, self._motion


@kernel
def free_step(inertial: Array, gravity: Array, applied: Array, body: Array, h: float) -> None:
    """One step of a free body, whose frame lies at its centre of mass along its principal axes.

    In body axes w += h I^-1 (M - w x I w), then q <- q exp(h w); v += h (F / m + g), then x += h v. `inertial` holds
    mass and principal moments (4,).
    """
    q = quaternion(body, 3)
    w = rotate(conjugate(q), vector(body, 10))
    M = rotate(conjugate(q), vector(applied, 3))
    Ix, Iy, Iz = vector(inertial, 1)
    w = (
        w[0] + h * (M[0] - (Iz - Iy) * w[1] * w[2]) / Ix,
        w[1] + h * (M[1] - (Ix - Iz) * w[2] * w[0]) / Iy,
        w[2] + h * (M[2] - (Iy - Ix) * w[0] * w[1]) / Iz,
    )
    turn(q, w, body, h)
    for i in range(3):
        body[7 + i] += h * (applied[i] / inertial[0] + gravity[i])
        body[i] += h * body[7 + i]


@kernel
def turn(q: Quaternion, w: Vector, body: Array, h: float) -> None:
    """Write into `body` attitude and angular velocity after a step at w, body axes, from the attitude q."""
    q = multiply(q, exponential((h * w[0], h * w[1], h * w[2])))
    norm = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    put_attitude((q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm), body)
    store(rotate(quaternion(body, 3), w), body, 10)


@kernel
def spherical_step(packed: Array, gravity: Array, applied: Array, body: Array, h: float) -> None:
    """One step of a body that turns about its held origin: w += h J^-1 (M - w x J w), then q <- q exp(h w).

    In body axes; M is the moment about the origin, `packed` is as `cdpr.mechanics.spherical.pack` returns it.
    """
    q = quaternion(body, 3)
    w = rotate(conjugate(q), vector(body, 10))
    M = rotate(conjugate(q), moment_about_ball(packed, gravity, q, vector(applied, 3)))
    c = cross(w, product(packed, INERTIA, w))
    a = product(packed, INVERSE, (M[0] - c[0], M[1] - c[1], M[2] - c[2]))
    turn(q, (w[0] + h * a[0], w[1] + h * a[1], w[2] + h * a[2]), body, h)


@kernel
def guided_step(
    guide: Array, inertial: Array, gravity: Array, applied: Array, motion: Array, body: Array, h: float
) -> None:
    """One step of a platform on a guide: u += h u', then q += h u, for the guide's coordinates q."""
    a, alpha = guided_acceleration(
        guide, inertial, gravity, motion[3], motion[7], vector(applied, 0), vector(applied, 3)
    )
    for i in range(3):
        motion[4 + i] += h * a[i]
        motion[i] += h * motion[4 + i]
    motion[7] += h * alpha
    motion[3] += h * motion[7]
    write_pose(guide, vector(motion, 0), motion[3], vector(motion, 4), motion[7], body)
