"""From Bullet's numbers to a body state."""

from __future__ import annotations

from cdpr.model.jit import kernel
from cdpr.model.kernels import Quaternion, Vector, conjugate, multiply, quaternion, rotate, store
from cdpr.model.robot import Array
from cdpr_backends.attitude import put_attitude


@kernel
def read_base(pose: tuple[Vector, Quaternion], twist: tuple[Vector, Vector], body: Array) -> None:
    """Write Bullet's base (position and x, y, z, w; velocity and angular velocity) into a body state (13,)."""
    p, q = pose
    v, w = twist
    put_attitude((q[3], q[0], q[1], q[2]), body)
    for i in range(3):
        body[i] = p[i]
        body[7 + i] = v[i]
        body[10 + i] = w[i]


@kernel
def read_ball(home: Array, axes: Array, joint: Quaternion, rate: Vector, body: Array) -> None:
    """Write a spherical joint of Bullet at `home` (3,) into a body state (13,): `joint` is x, y, z, w; see `Ball`."""
    turned = quaternion(axes, 0)
    link = multiply(turned, (joint[3], joint[0], joint[1], joint[2]))
    put_attitude(multiply(link, conjugate(turned)), body)
    store(rotate(link, rate), body, 10)
    for i in range(3):
        body[i] = home[i]
        body[7 + i] = 0.0
