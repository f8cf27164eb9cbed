"""Quaternions as they come from engines."""

from __future__ import annotations

from cdpr.model.jit import kernel
from cdpr.model.kernels import Quaternion
from cdpr.model.robot import Array


@kernel
def put_attitude(q: Quaternion, body: Array) -> None:
    """Write an attitude w, x, y, z into a body state (13,), with that of its two signs which is next to the last one.

    Engines choose the sign as they like, and change it in mid-turn.
    """
    sign = 1.0 if q[0] * body[3] + q[1] * body[4] + q[2] * body[5] + q[3] * body[6] >= 0.0 else -1.0
    for i in range(4):
        body[3 + i] = sign * q[i]
