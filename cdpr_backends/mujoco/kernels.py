"""Between MuJoCo's joints and a body state."""

from __future__ import annotations

from cdpr.model.jit import kernel
from cdpr.model.kernels import conjugate, quaternion, rotate, store, vector
from cdpr.model.robot import Array


@kernel
def read_free_joint(qpos: Array, qvel: Array, body: Array) -> None:
    """Read MuJoCo's free joint, whose angular velocity is in body axes, into a body state (13,)."""
    for i in range(7):
        body[i] = qpos[i]
    for i in range(3):
        body[7 + i] = qvel[i]
    store(rotate(quaternion(qpos, 3), vector(qvel, 3)), body, 10)


@kernel
def write_free_joint(body: Array, qpos: Array, qvel: Array) -> None:
    """Undo `read_free_joint`."""
    for i in range(7):
        qpos[i] = body[i]
    for i in range(3):
        qvel[i] = body[7 + i]
    store(rotate(conjugate(quaternion(body, 3)), vector(body, 10)), qvel, 3)


@kernel
def read_ball(home: Array, qpos: Array, qvel: Array, body: Array) -> None:
    """Read MuJoCo's ball joint at `home` (3,), whose angular velocity is in body axes, into a body state (13,)."""
    for i in range(4):
        body[3 + i] = qpos[i]
    for i in range(3):
        body[i] = home[i]
        body[7 + i] = 0.0
    store(rotate(quaternion(qpos, 0), vector(qvel, 0)), body, 10)


@kernel
def write_ball(body: Array, qpos: Array, qvel: Array) -> None:
    """Undo `read_ball`."""
    for i in range(4):
        qpos[i] = body[3 + i]
    store(rotate(conjugate(quaternion(body, 3)), vector(body, 10)), qvel, 0)
