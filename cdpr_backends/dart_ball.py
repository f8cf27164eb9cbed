"""DART's ball joint, for platforms that turn about their held origin."""

from __future__ import annotations

from typing import Any

import dartpy
import numpy as np

from cdpr.model.body_frame import BodyFrame
from cdpr.model.jit import kernel
from cdpr.model.kernels import Quaternion, conjugate, multiply, quaternion, rotate, store, vector
from cdpr.model.robot import Array
from cdpr_backends.dart import facing, follow_turn, put_root, sane, set_motion, turn_axes, write_rotation


class BallJoint:
    """A platform on a ball as DART moves it, but for what DART loses of its attitude: as with `dart.FreeJoint`.

    The joint has the rotation vector of DART's body axes as coordinates, and the angular velocity along them.

    Attributes:
        skeleton: DART's.
        kept: (7,) how DART's body axes are turned in ours, w, x, y, z, and where the ball is, world.
    """

    def __init__(self, world: Any, frame: BodyFrame, body: Array, step: float) -> None:
        self.skeleton = dartpy.dynamics.Skeleton("platform")
        _, self._link = self.skeleton.createBallJointAndBodyNodePair()
        self._frame, self._body, self._step = frame, body, step
        self.kept = np.zeros(7)
        self._face()
        world.addSkeleton(self.skeleton)

    def place(self) -> None:
        """Turn DART's body axes and put the ball as `kept` says."""
        turn_axes(self._link, self._frame, self.kept)
        put_root(self.skeleton, self.kept[4:])

    def write(self) -> None:
        """Put the body into `body`."""
        self._body[7:10] = 0.0
        self.kept[4:] = self._body[:3]
        self._face()
        q, u = np.zeros(3), np.zeros(3)
        write_rotation(self.kept, self._body, q)
        along_axes(self.kept, self._body, self._body[10:], u)
        set_motion(self.skeleton, q, u)

    def moved(self) -> None:
        """Read the body into `body` after a step."""
        q, u = self.skeleton.getPositions(), self.skeleton.getVelocities()
        if follow_ball(self.kept, self._step, q, u, self._body):
            self._face()
            write_rotation(self.kept, self._body, q)
            along_axes(self.kept, self._body, self._body[10:], u)
            self.skeleton.setVelocities(u)
        self.skeleton.setPositions(q)

    def _face(self) -> None:
        """Turn DART's body axes anew."""
        self.kept[:4] = facing(self._body)
        self.place()


@kernel
def dart_attitude(kept: Array, body: Array) -> Quaternion:
    """Attitude of DART's body axes for a body state (13,)."""
    return multiply(quaternion(body, 3), quaternion(kept, 0))


@kernel
def along_axes(kept: Array, body: Array, v: Array, turned: Array) -> None:
    """Write a vector (3,) in world axes along DART's body axes."""
    store(rotate(conjugate(dart_attitude(kept, body)), vector(v, 0)), turned, 0)


@kernel
def ball_joint_force(kept: Array, body: Array, applied: Array, forces: Array) -> bool:
    """Write the moment of what is applied (6,) along DART's body axes (3,) and return whether it is sane."""
    along_axes(kept, body, applied[3:], forces)
    return sane(body, applied)


@kernel
def follow_ball(kept: Array, step: float, q: Array, u: Array, body: Array) -> bool:
    """Move a body state (13,) to the end of DART's step, as `dart.follow` does; a turn leaves its own axis alone."""
    return follow_turn(kept, step, rotate(dart_attitude(kept, body), vector(u, 0)), q, body)
