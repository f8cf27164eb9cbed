"""Joints of a platform in DART: a free joint, a spherical joint, or the slides and the hinge of its guide."""

from __future__ import annotations

from typing import Any

import dartpy
import numpy as np

from cdpr.mechanics.body_frame import BodyFrame
from cdpr.mechanics.guide import Guide
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.native.rotations import from_rotation_vector, multiply, rotate, rotation_vector
from cdpr.plugins.inertia import Inertia
from cdpr_backends.dart.world import chain, held, put_root, set_inertia, set_motion

# For rotation vectors below 1e-3 rad, DART truncates the exponential after the second power (joints.hpp). So DART's
# body axes are rotated relative to cdpr's, by this rotation from the current attitude.
FACING = from_rotation_vector((0.6, 0.5, 0.4))


class FreeJoint:
    """Free platform in DART with a correction of DART's attitude errors.

    After each step, the attitude is set to the exact rotation for DART's angular velocity: see `FACING`.

    Attributes:
        skeleton: DART skeleton.
        push: function that sets the joint forces until the end of the step.
        kept: (4,) rotation of DART's body axes in the body frame, w, x, y, z.
    """

    def __init__(self, world: Any, frame: BodyFrame, body: Array, step: float) -> None:
        self.skeleton = dartpy.dynamics.Skeleton("platform")
        joint, self._link = self.skeleton.createFreeJointAndBodyNodePair()
        self._frame, self._body = frame, body
        self.kept = FACING.copy()
        self.place()
        world.addSkeleton(self.skeleton)
        self._q, self._u = np.zeros(6), np.zeros(6)
        moving = {"coordinates": self._q, "rates": self._u, "body": body}
        self._follow = bind("dart_follow_free", kept=self.kept, **moving, step=step)
        # The joint is the only one, and quicker than the skeleton.
        self.push, self._set_q = joint.setForces, joint.setPositions
        self._get_q, self._get_u = joint.getPositions, joint.getVelocities

    def place(self) -> None:
        """Rotate DART's body axes by `kept`."""
        turn_axes(self._link, self._frame, self.kept)

    def write(self) -> None:
        """Set DART's body to the state in `body`."""
        self._face()
        body = self._body
        q = np.concatenate([rotation(self.kept, body), body[:3]])
        set_motion(self.skeleton, q, np.concatenate([body[10:], body[7:10]]))

    def load(self) -> None:
        """Take the mass properties of the frame and the state in `body`; its axes face it anew."""
        self.write()

    def moved(self) -> None:
        """Read DART's body into `body` after a step."""
        self._q[:], self._u[:] = self._get_q(), self._get_u()
        if self._follow():
            self._face()
            self._q[:3] = rotation(self.kept, self._body)
        self._set_q(self._q)

    def held(self) -> Inertia:
        """Return the inertia of the body in DART."""
        return held(self._link, self.kept[:4])

    def _face(self) -> None:
        """Choose the rotation of DART's body axes for the current attitude."""
        self.kept[:4] = facing(self._body)
        self.place()


class BallJoint:
    """Platform on a spherical joint in DART, with the same correction as `FreeJoint`.

    The coordinates of the joint are the rotation vector of DART's body axes. Its rates are the angular velocity along
    them.

    Attributes:
        skeleton: DART skeleton.
        push: function that sets the joint forces until the end of the step.
        kept: (7,) rotation of DART's body axes in the body frame, w, x, y, z, and position of the joint in the world
            frame.
    """

    def __init__(self, world: Any, frame: BodyFrame, body: Array, step: float) -> None:
        self.skeleton = dartpy.dynamics.Skeleton("platform")
        joint, self._link = self.skeleton.createBallJointAndBodyNodePair()
        self._frame, self._body = frame, body
        self.kept = np.zeros(7)
        self._face()
        world.addSkeleton(self.skeleton)
        self._q, self._u = np.zeros(3), np.zeros(3)
        moving = {"coordinates": self._q, "rates": self._u, "body": body}
        self._follow = bind("dart_follow_ball", kept=self.kept, **moving, step=step)
        self.push, self._set_q, self._set_u = joint.setForces, joint.setPositions, joint.setVelocities
        self._get_q, self._get_u = joint.getPositions, joint.getVelocities

    def place(self) -> None:
        """Rotate DART's body axes and place the joint by `kept`."""
        turn_axes(self._link, self._frame, self.kept)
        put_root(self.skeleton, self.kept[4:])

    def write(self) -> None:
        """Set DART's body to the state in `body`."""
        self._body[7:10] = 0.0
        self.kept[4:] = self._body[:3]
        self._face()
        set_motion(self.skeleton, rotation(self.kept, self._body), self._rates())

    def load(self) -> None:
        """Take the mass properties of the frame and the state in `body`; its axes face it anew."""
        self.write()

    def moved(self) -> None:
        """Read DART's body into `body` after a step."""
        self._q[:], self._u[:] = self._get_q(), self._get_u()
        if self._follow():
            self._face()
            self._q[:] = rotation(self.kept, self._body)
            self._set_u(self._rates())
        self._set_q(self._q)

    def held(self) -> Inertia:
        """Return the inertia of the body in DART."""
        return held(self._link, self.kept[:4])

    def _rates(self) -> Array:
        """Return the angular velocity along DART's body axes."""
        return rotate(rotations.conjugate(attitude(self.kept, self._body)), self._body[10:])

    def _face(self) -> None:
        """Choose the rotation of DART's body axes for the current attitude."""
        self.kept[:4] = facing(self._body)
        self.place()


class GuideJoints:
    """Platform on the joints of its guide.

    Attributes:
        skeleton: DART skeleton.
        push: function that sets the joint forces until the end of the step.
        kept: (3,) origin of the slides in the world frame.
    """

    def __init__(self, world: Any, frame: BodyFrame, guide: Guide, body: Array) -> None:
        self.skeleton = dartpy.dynamics.Skeleton("platform")
        self._guide, self._body, self._frame = guide, body, frame
        self.kept = np.zeros(3)
        kinds = ["Prismatic"] * len(guide.slides)
        directions = list(guide.slides)
        if guide.hinge is not None:
            kinds.append("Revolute")
            directions.append(guide.hinge)
        self._link = chain(self.skeleton, kinds, np.eye(3)[directions], frame.mass, frame.center, self._tensor())
        world.addSkeleton(self.skeleton)
        self._q, self._u = np.zeros(len(kinds)), np.zeros(len(kinds))
        joints = {"coordinate": self._q, "rate": self._u, "body": body}
        self._read = bind("guide_state", guide=guide.packed, rows=guide.rows, home=self.kept, **joints)
        self.push = self.skeleton.setForces
        self._get_q, self._get_u = self.skeleton.getPositions, self.skeleton.getVelocities

    def place(self) -> None:
        """Place the first joint by `kept`."""
        put_root(self.skeleton, self.kept)

    def write(self) -> None:
        """Set DART's body to the state in `body`."""
        self.kept[:] = self._body[:3] * (1.0 - self._guide.packed[:3])
        self.place()
        set_motion(self.skeleton, *self._guide.coordinates(self._body, self.kept))
        self.moved()

    def load(self) -> None:
        """Take the mass properties of the frame; coordinates and rates do not depend on them."""
        set_inertia(self._link, self._frame.mass, self._frame.center, self._tensor())

    def _tensor(self) -> Array:
        axes = rotations.matrix(self._frame.axes)
        return np.asarray(axes * self._frame.moments @ axes.T)

    def held(self) -> Inertia:
        """Return the inertia of the body in DART."""
        return held(self._link, np.array([1.0, 0.0, 0.0, 0.0]))

    def moved(self) -> None:
        """Read DART's body into `body`."""
        self._q[:], self._u[:] = self._get_q(), self._get_u()
        self._read()


def attitude(kept: Array, body: Array) -> Array:
    """Return the attitude of DART's body axes, w, x, y, z."""
    return multiply(body[3:7], kept[:4])


def rotation(kept: Array, body: Array) -> Array:
    """Return the rotation vector (3,) of DART's body axes [rad]."""
    return rotation_vector(attitude(kept, body))


def facing(body: Array) -> Array:
    """Return the rotation of DART's body axes in the body frame that gives them the attitude FACING."""
    return multiply(rotations.conjugate(body[3:7]), FACING)


def turn_axes(link: Any, frame: BodyFrame, kept: Array) -> None:
    """Set the inertia of a link to that of the platform, in axes rotated by `kept`, w, x, y, z, in the body frame."""
    turned = rotations.conjugate(kept[:4])
    axes = rotations.matrix(multiply(turned, frame.axes))
    inertia = axes * frame.moments @ axes.T
    center = rotate(turned, frame.center)
    set_inertia(link, frame.mass, center, inertia)
