"""From Bullet's numbers to a body state."""

from __future__ import annotations

from cdpr.model.jit import kernel
from cdpr.model.kernels import conjugate, multiply, quaternion, rotate, store, vector
from cdpr.model.robot import Array
from cdpr_backends.attitude import put_attitude


@kernel
def read_base(base: Array, body: Array) -> None:
    """Write Bullet's base (13,), position, x, y, z, w, velocity and angular velocity, into a body state (13,)."""
    put_attitude((base[6], base[3], base[4], base[5]), body)
    for i in range(3):
        body[i] = base[i]
        body[7 + i] = base[7 + i]
        body[10 + i] = base[10 + i]


@kernel
def read_ball(home: Array, axes: Array, joint: Array, body: Array) -> None:
    """Write a spherical joint of Bullet at `home` (3,) into a body state (13,), see `Ball`.

    joint: x, y, z, w, and the rate (7,).
    """
    turned = quaternion(axes, 0)
    link = multiply(turned, (joint[3], joint[0], joint[1], joint[2]))
    put_attitude(multiply(link, conjugate(turned)), body)
    store(rotate(link, vector(joint, 4)), body, 10)
    for i in range(3):
        body[i] = home[i]
        body[7 + i] = 0.0
