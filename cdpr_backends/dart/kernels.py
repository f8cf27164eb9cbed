"""Between DART's joints and a body state: what moves the platform, and what DART loses of its attitude."""

from __future__ import annotations

import math

from cdpr.mechanics.guide import IntArray, onto_coordinates
from cdpr.model.jit import kernel
from cdpr.model.kernels import (
    Quaternion,
    Vector,
    conjugate,
    dot,
    exponential,
    logarithm,
    multiply,
    quaternion,
    rotate,
    store,
    vector,
)
from cdpr.model.robot import Array

# DART drops forces that are not finite, and where numbers overflow it prints warnings without end and goes on with
# zeros. Above this force, N or N m, or speed, m/s or rad/s, it is not asked to step: the state becomes NaN.
SANE = 1e12

# DART cuts the exponential of a rotation vector below 1e-3 rad off after its second power, which is wrong by a sixth of
# the third: 2e-10 rad. It takes that of a joint's attitude and that of the turn of each step. So its body axes are
# turned in ours, by the first from the attitude at hand, again where that attitude comes nearer to zero than NEAR rad.
FACING = exponential((0.6, 0.5, 0.4))
NEAR = 0.2


@kernel
def only_sane(body: Array, applied: Array, forces: Array) -> None:
    """Write NaN for the first of forces (n,) where DART cannot be trusted with this motion (13,) and wrench (6,)."""
    largest = 0.0
    for i in range(6):
        largest += abs(applied[i]) + abs(body[7 + i])
    if not largest < SANE:
        forces[0] = math.nan


@kernel
def free_joint_force(body: Array, applied: Array, forces: Array) -> None:
    """Write the free joint's forces (moment, then force, world axes), or NaN, see `only_sane`."""
    for i in range(3):
        forces[i] = applied[3 + i]
        forces[3 + i] = applied[i]
    only_sane(body, applied, forces)


@kernel
def guide_force(rows: IntArray, body: Array, applied: Array, forces: Array) -> None:
    """Write the forces (n,) along the guide's coordinates, or NaN, see `only_sane`."""
    onto_coordinates(rows, applied, forces)
    only_sane(body, applied, forces)


@kernel
def follow(kept: Array, step: float, q: Array, u: Array, body: Array) -> bool:
    """Move a body state (13,) to the end of DART's step and put its attitude into DART's coordinates.

    The free joint has rotation vector and position (6,), angular velocity and velocity (6,). Returns whether the
    rotation vector has come too near to zero for DART's next step.
    """
    for i in range(3):
        body[i] = q[3 + i]
        body[7 + i] = u[3 + i]
    return follow_turn(kept, step, vector(u, 0), q, body)


@kernel
def follow_turn(kept: Array, step: float, w: Vector, q: Array, body: Array) -> bool:
    """Do what `follow` does for attitude and angular velocity alone, the latter being w at the end, world axes."""
    a = multiply(exponential((step * w[0], step * w[1], step * w[2])), quaternion(body, 3))
    scale = 1.0 / math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2] + a[3] * a[3])  # else round-off would add up
    for i in range(4):
        body[3 + i] = scale * a[i]
    store(w, body, 10)
    write_rotation(kept, body, q)
    return dot(vector(q, 0), vector(q, 0)) < NEAR * NEAR


@kernel
def write_rotation(kept: Array, body: Array, q: Array) -> None:
    """Write the rotation vector of DART's axes for a body state (13,) into the first of DART's coordinates."""
    store(logarithm(multiply(quaternion(body, 3), quaternion(kept, 0))), q, 0)


@kernel
def write_free_joint(kept: Array, body: Array, q: Array, u: Array) -> None:
    """Write coordinates and rates, (6,) each, of DART's free joint for a body state (13,)."""
    write_rotation(kept, body, q)
    store(vector(body, 0), q, 3)
    store(vector(body, 10), u, 0)
    store(vector(body, 7), u, 3)


@kernel
def dart_attitude(kept: Array, body: Array) -> Quaternion:
    """Attitude of DART's body axes for a body state (13,)."""
    return multiply(quaternion(body, 3), quaternion(kept, 0))


@kernel
def along_axes(kept: Array, body: Array, v: Array, turned: Array) -> None:
    """Write a vector (3,) in world axes along DART's body axes."""
    store(rotate(conjugate(dart_attitude(kept, body)), vector(v, 0)), turned, 0)


@kernel
def ball_joint_force(kept: Array, body: Array, applied: Array, forces: Array) -> None:
    """Write the moment of what is applied (6,) along DART's body axes (3,), or NaN, see `only_sane`."""
    along_axes(kept, body, applied[3:], forces)
    only_sane(body, applied, forces)


@kernel
def follow_ball(kept: Array, step: float, q: Array, u: Array, body: Array) -> bool:
    """Move a body state (13,) to the end of DART's step, as `follow` does; a turn leaves its own axis alone."""
    return follow_turn(kept, step, rotate(dart_attitude(kept, body), vector(u, 0)), q, body)
