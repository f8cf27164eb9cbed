"""What DART moves a platform on: a free joint, a ball, or the slides and the hinge of its guide."""

from __future__ import annotations

from functools import partial
from typing import Any

import dartpy
import numpy as np

from cdpr.mechanics.body_frame import BodyFrame
from cdpr.mechanics.guide import Guide, from_coordinates
from cdpr.model import rotations
from cdpr.model.kernels import Quaternion, conjugate, multiply, quaternion, rotate, vector
from cdpr.model.robot import Array
from cdpr.plugins.inertia import Inertia
from cdpr_backends.dart.kernels import FACING, along_axes, follow, follow_ball, write_free_joint, write_rotation
from cdpr_backends.dart.world import chain, held, put_root, set_motion


class FreeJoint:
    """A free platform as DART moves it, but for what DART loses of its attitude.

    DART steps, and its attitude is then put right by the exact turn at DART's angular velocity: see `FACING`.

    Attributes:
        skeleton: DART's.
        push: its joints' forces, until the step is over.
        kept: (4,) how DART's body axes are turned in ours, w, x, y, z.
    """

    def __init__(self, world: Any, frame: BodyFrame, body: Array, step: float) -> None:
        self.skeleton = dartpy.dynamics.Skeleton("platform")
        joint, self._link = self.skeleton.createFreeJointAndBodyNodePair()
        self._frame, self._body, self._step = frame, body, step
        self.kept = np.array(FACING)
        self.place()
        world.addSkeleton(self.skeleton)
        # The joint is the only one, and quicker than the skeleton.
        self.push, self._set_q = joint.setForces, joint.setPositions
        self._get_q, self._get_u = joint.getPositions, joint.getVelocities

    def place(self) -> None:
        """Turn DART's body axes as `kept` says."""
        turn_axes(self._link, self._frame, self.kept)

    def write(self) -> None:
        """Put the body into `body`."""
        self._face()
        q, u = np.zeros(6), np.zeros(6)
        write_free_joint(self.kept, self._body, q, u)
        set_motion(self.skeleton, q, u)

    def moved(self) -> None:
        """Read the body into `body` after a step."""
        q = self._get_q()
        if follow(self.kept, self._step, q, self._get_u(), self._body):
            self._face()
            write_rotation(self.kept, self._body, q)
        self._set_q(q)

    def held(self) -> Inertia:
        """Return the inertia that DART holds."""
        return held(self._link, self.kept[:4])

    def _face(self) -> None:
        """Turn DART's body axes anew."""
        self.kept[:4] = facing(self._body)
        self.place()


class BallJoint:
    """A platform on a ball as DART moves it, but for what DART loses of its attitude: as with `FreeJoint`.

    The joint has the rotation vector of DART's body axes as coordinates, and the angular velocity along them.

    Attributes:
        skeleton: DART's.
        push: its joints' forces, until the step is over.
        kept: (7,) how DART's body axes are turned in ours, w, x, y, z, and where the ball is, world.
    """

    def __init__(self, world: Any, frame: BodyFrame, body: Array, step: float) -> None:
        self.skeleton = dartpy.dynamics.Skeleton("platform")
        joint, self._link = self.skeleton.createBallJointAndBodyNodePair()
        self._frame, self._body, self._step = frame, body, step
        self.kept = np.zeros(7)
        self._face()
        world.addSkeleton(self.skeleton)
        self.push, self._set_q, self._set_u = joint.setForces, joint.setPositions, joint.setVelocities
        self._get_q, self._get_u = joint.getPositions, joint.getVelocities

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
        q, u = self._get_q(), self._get_u()
        if follow_ball(self.kept, self._step, q, u, self._body):
            self._face()
            write_rotation(self.kept, self._body, q)
            along_axes(self.kept, self._body, self._body[10:], u)
            self._set_u(u)
        self._set_q(q)

    def held(self) -> Inertia:
        """Return the inertia that DART holds."""
        return held(self._link, self.kept[:4])

    def _face(self) -> None:
        """Turn DART's body axes anew."""
        self.kept[:4] = facing(self._body)
        self.place()


class GuideJoints:
    """A platform on the joints of its guide.

    Attributes:
        skeleton: DART's.
        push: its joints' forces, until the step is over.
        kept: (3,) where the slides measure from, world.
    """

    def __init__(self, world: Any, frame: BodyFrame, guide: Guide, body: Array) -> None:
        self.skeleton = dartpy.dynamics.Skeleton("platform")
        self._guide, self._body = guide, body
        self.kept = np.zeros(3)
        axes = rotations.matrix(frame.axes)
        kinds = ["Prismatic"] * len(guide.slides)
        directions = list(guide.slides)
        if guide.hinge is not None:
            kinds.append("Revolute")
            directions.append(guide.hinge)
        inertia = axes * frame.moments @ axes.T
        self._link = chain(self.skeleton, kinds, np.eye(3)[directions], frame.mass, frame.center, inertia)
        world.addSkeleton(self.skeleton)
        self._read = partial(from_coordinates, guide.packed, guide.rows, self.kept)
        self.push = self.skeleton.setForces
        self._get_q, self._get_u = self.skeleton.getPositions, self.skeleton.getVelocities

    def place(self) -> None:
        """Put the first joint where `kept` says."""
        put_root(self.skeleton, self.kept)

    def write(self) -> None:
        """Put the body into `body`."""
        self.kept[:] = self._body[:3] * (1.0 - self._guide.packed[:3])
        self.place()
        set_motion(self.skeleton, *self._guide.coordinates(self._body, self.kept))
        self.moved()

    def held(self) -> Inertia:
        """Return the inertia that DART holds."""
        return held(self._link, np.array([1.0, 0.0, 0.0, 0.0]))

    def moved(self) -> None:
        """Read the body into `body`."""
        self._read(self._get_q(), self._get_u(), self._body)


def facing(body: Array) -> Quaternion:
    """How DART's body axes are to be turned in ours: by FACING from where they would be at DART's zero."""
    return multiply(conjugate(quaternion(body, 3)), FACING)


def turn_axes(link: Any, frame: BodyFrame, kept: Array) -> None:
    """Give a link the platform's inertia in axes that are turned by `kept`, w, x, y, z, in ours."""
    turned = conjugate(quaternion(kept, 0))
    axes = rotations.matrix(np.array(multiply(turned, quaternion(frame.axes, 0))))
    inertia = axes * frame.moments @ axes.T
    center = np.array(rotate(turned, vector(frame.center, 0)))
    link.setInertia(dartpy.dynamics.Inertia(frame.mass, center, (inertia + inertia.T) / 2))
