"""Bullet worlds: import without output, clients, their saved states, and bodies without Bullet's default effects."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np

from cdpr.base.errors import PluginError
from cdpr.base.redirect_output import discarded_output
from cdpr.model.robot import Array
from cdpr.plugins.inertia import Inertia, turned
from cdpr_backends import BULLET_RANGE

with discarded_output():  # it prints its build time
    import pybullet as pybullet  # as: re-exported for modules that must import it without output

BASE = -1
UPRIGHT = (0.0, 0.0, 0.0, 1.0)  # Bullet's quaternions are x, y, z, w

TITLE = "Bullet"
SMALLEST = BULLET_RANGE["smallest"]

# Bullet clips speeds without a warning, by default at 100 m/s and rad/s. The run stops long before this limit.
NO_CLIP = 1e12


class Client:
    """Empty Bullet world without a window, closed by `close` or with its last reference."""

    def __init__(self, gravity: Array, step: float) -> None:
        self.number = number = int(pybullet.connect(pybullet.DIRECT))
        if number < 0:
            raise PluginError("PyBullet opens no more worlds in this process; close some backends")
        self.close = weakref.finalize(self, pybullet.disconnect, number)
        pybullet.setGravity(*gravity.tolist(), physicsClientId=number)
        pybullet.setTimeStep(step, number)


class SavedState:
    """Saved state of a client, which Bullet keeps for the lifetime of this object."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._number = pybullet.saveState(client.number)
        weakref.finalize(self, _forget, self._number, client.number, client.close)

    def restore(self) -> None:
        """Restore this state of the client."""
        pybullet.restoreState(stateId=self._number, physicsClientId=self._client.number)


def _forget(number: int, client: int, close: weakref.finalize[Any, Any]) -> None:
    if close.alive:  # a client that is closed has no states, and its number may be that of another
        pybullet.removeState(number, client)


def chain(
    client: int,
    base: Sequence[float],
    kinds: Sequence[int],
    directions: Array,
    mass: float,
    moments: Array,
    center: Sequence[float],
    axes: Sequence[float],
) -> int:
    """Add massless and frictionless links on a fixed base, and a last link with mass, moments, centre and axes."""
    n = len(kinds)
    nowhere = [[0.0, 0.0, 0.0]] * n
    number = int(
        pybullet.createMultiBody(
            baseMass=0.0,
            basePosition=base,
            linkMasses=[0.0] * (n - 1) + [mass],
            linkCollisionShapeIndices=[-1] * n,
            linkVisualShapeIndices=[-1] * n,
            linkPositions=nowhere,
            linkOrientations=[UPRIGHT] * n,
            linkInertialFramePositions=[*nowhere[1:], center],
            linkInertialFrameOrientations=[UPRIGHT] * (n - 1) + [axes],
            linkParentIndices=list(range(n)),
            linkJointTypes=list(kinds),
            linkJointAxis=directions.tolist(),
            physicsClientId=client,
        )
    )
    pybullet.changeDynamics(number, n - 1, localInertiaDiagonal=moments.tolist(), physicsClientId=client)
    for joint in range(n):
        pybullet.setJointMotorControl2(number, joint, pybullet.VELOCITY_CONTROL, force=0.0, physicsClientId=client)
    undamped(client, number)
    return number


def held(client: int, number: int, link: int) -> Inertia:
    """Return the inertia of a body's link in Bullet, in its frame."""
    mass, _, moments, center, (x, y, z, w), *_ = pybullet.getDynamicsInfo(number, link, client)
    return Inertia(mass, turned(np.array(moments), np.array([w, x, y, z])), np.array(center))


def undamped(client: int, number: int) -> None:
    """Disable damping (0.04 by default), the clipping of speeds and sleeping for a body and its links."""
    for link in range(BASE, pybullet.getNumJoints(number, client)):
        pybullet.changeDynamics(
            number,
            link,
            linearDamping=0.0,
            angularDamping=0.0,
            jointDamping=0.0,
            maxJointVelocity=NO_CLIP,
            activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
            physicsClientId=client,
        )


def xyzw(q: Array) -> list[float]:
    """Return a quaternion w, x, y, z in Bullet's order."""
    w, x, y, z = q.tolist()
    return [x, y, z, w]
