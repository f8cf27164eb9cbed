"""DART: one body under our cable wrench, on a free joint, a ball or the slides and the hinge of its guide."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import dartpy
import numpy as np

from cdpr.model import Robot, rotations
from cdpr.model.body_frame import BodyFrame
from cdpr.model.guide import Guide, IntArray, from_coordinates, onto_coordinates
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
from cdpr.plugins import Backend, RigidBodyBackend
from cdpr.plugins.snapshots import put_back, save

if TYPE_CHECKING:
    from cdpr_backends.dart_ball import BallJoint

# DART drops forces that are not finite, and where numbers overflow it prints warnings without end and goes on with
# zeros. Above this force, N or N m, or speed, m/s or rad/s, it is not asked to step: the state becomes NaN.
SANE = 1e12

# Links between joints have no mass, but DART warns of less than something. This is lost in the first sum.
NO_MASS = 1e-100


# DART cuts the exponential of a rotation vector below 1e-3 rad off after its second power, which is wrong by a sixth of
# the third: 2e-10 rad. It takes that of a joint's attitude and that of the turn of each step. So its body axes are
# turned in ours, by the first from the attitude at hand, again where that attitude comes nearer to zero than NEAR rad.
FACING = exponential((0.6, 0.5, 0.4))
NEAR = 0.2


def make(robot: Robot, gravity: Array, physics_step: float, options: Any) -> Backend:
    """Return the backend for the chosen kind of cables."""
    if options.cables == "ups":
        from cdpr_backends.dart_ups import DartUps

        return DartUps(robot, gravity, physics_step, options)
    return DartBackend(robot, gravity, physics_step, options)


class DartBackend(RigidBodyBackend):
    """A body under the wrench of cdpr's cable kernel."""

    def build(self) -> None:
        """Make the world."""
        self.world = world = make_world(self.gravity, self.physics_step)
        frame, body, applied = self.frame, self.body, self.applied
        self.joints: FreeJoint | BallJoint | GuideJoints
        if frame.guide is None:
            self.joints = FreeJoint(world, frame, body, self.physics_step)
            forces = np.zeros(6)
            onto_joints: Callable[[], bool] = partial(free_joint_force, body, applied, forces)
        elif frame.guide.spherical:
            from cdpr_backends.dart_ball import BallJoint, ball_joint_force

            self.joints = BallJoint(world, frame, body, self.physics_step)
            forces = np.zeros(3)
            onto_joints = partial(ball_joint_force, self.joints.kept, body, applied, forces)
        else:
            self.joints = GuideJoints(world, frame, frame.guide, body)
            forces = np.zeros(self.joints.skeleton.getNumDofs())
            onto_joints = partial(guide_force, frame.guide.rows, body, applied, forces)
        push, step, moved = self.joints.skeleton.setForces, world.step, self.joints.moved

        def advance() -> None:
            self._sane = onto_joints()
            if self._sane:
                push(forces)
                step()
                moved()
            else:
                body[:] = np.nan

        self._advance = advance

    def write(self) -> None:
        """Put the body into `body`."""
        self._sane = True
        self.world.reset()
        self.joints.write()

    def read(self) -> None:
        """Do nothing: what moves the body reads it, too."""

    def advance(self) -> None:
        """Advance by one physics step."""
        self._advance()

    def engine_time(self) -> float:
        """Return DART's time, s."""
        return float(self.world.getTime())

    def snapshot(self) -> object:
        """Return joint coordinates and rates, DART's time and our arrays."""
        skeleton = self.joints.skeleton
        return (skeleton.getPositions(), skeleton.getVelocities()), self.world.getTime(), self._sane, save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Go back to a snapshot."""
        coordinates, time, self._sane, arrays = snapshot
        put_back(arrays, self.arrays)
        self.world.setTime(time)
        self.joints.place()
        set_motion(self.joints.skeleton, *coordinates)

    @property
    def arrays(self) -> tuple[Array, ...]:
        """What a snapshot must hold besides DART's own state."""
        return *super().arrays, self.joints.kept


def make_world(gravity: Array, step: float) -> Any:
    """Return an empty world, in which nothing falls asleep."""
    world = dartpy.simulation.World()
    world.setGravity(gravity)
    world.setTimeStep(step)
    sleep = world.getDeactivationOptions()
    sleep.mEnabled = False
    world.setDeactivationOptions(sleep)
    return world


class FreeJoint:
    """A free platform as DART moves it, but for what DART loses of its attitude.

    DART steps, and its attitude is then put right by the exact turn at DART's angular velocity: see `FACING`.

    Attributes:
        skeleton: DART's.
        kept: (4,) how DART's body axes are turned in ours, w, x, y, z.
    """

    def __init__(self, world: Any, frame: BodyFrame, body: Array, step: float) -> None:
        self.skeleton = dartpy.dynamics.Skeleton("platform")
        _, self._link = self.skeleton.createFreeJointAndBodyNodePair()
        self._frame, self._body, self._step = frame, body, step
        self.kept = np.array(FACING)
        self.place()
        world.addSkeleton(self.skeleton)
        self._get_q, self._get_u, self._set_q = (
            self.skeleton.getPositions,
            self.skeleton.getVelocities,
            self.skeleton.setPositions,
        )

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

    def _face(self) -> None:
        """Turn DART's body axes anew."""
        self.kept[:4] = facing(self._body)
        self.place()


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


class GuideJoints:
    """A platform on the joints of its guide.

    Attributes:
        skeleton: DART's.
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
        chain(self.skeleton, kinds, np.eye(3)[directions], frame.mass, frame.center, axes * frame.moments @ axes.T)
        world.addSkeleton(self.skeleton)
        self._read = partial(from_coordinates, guide.packed, guide.rows, self.kept)
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

    def moved(self) -> None:
        """Read the body into `body`."""
        self._read(self._get_q(), self._get_u(), self._body)


def chain(skeleton: Any, kinds: Sequence[str], directions: Array, mass: float, center: Array, inertia: Array) -> Any:
    """Add one link per joint, the last one with mass, centre and inertia; return that one."""
    link: Any = None
    for kind, axis in zip(kinds, directions, strict=True):
        add = getattr(skeleton, f"create{kind}JointAndBodyNodePair")
        joint, link = add() if link is None else add(link)
        joint.setAxis(axis)
        link.setInertia(dartpy.dynamics.Inertia(NO_MASS, np.zeros(3), NO_MASS * np.eye(3)))
    link.setInertia(dartpy.dynamics.Inertia(mass, center, (inertia + inertia.T) / 2))
    return link


def put_root(skeleton: Any, position: Array) -> None:
    """Put the first joint of a skeleton at a position (3,), world."""
    place = dartpy.math.Isometry3()
    place.set_translation(position)
    skeleton.getRootJoint().setTransformFromParentBodyNode(place)


def set_motion(skeleton: Any, q: Array, u: Array) -> None:
    """Set joint coordinates and rates and forget all forces."""
    skeleton.resetAccelerations()
    skeleton.clearExternalForces()
    skeleton.resetGeneralizedForces()
    skeleton.setPositions(q)
    skeleton.setVelocities(u)


@kernel
def sane(body: Array, applied: Array) -> bool:
    """Whether DART can be trusted with this motion (13,) and this wrench (6,); not so with NaN."""
    largest = 0.0
    for i in range(6):
        largest += abs(applied[i]) + abs(body[7 + i])
    return largest < SANE


@kernel
def free_joint_force(body: Array, applied: Array, forces: Array) -> bool:
    """Write the free joint's forces (moment, then force, world axes) and return whether they are sane."""
    for i in range(3):
        forces[i] = applied[3 + i]
        forces[3 + i] = applied[i]
    return sane(body, applied)


@kernel
def guide_force(rows: IntArray, body: Array, applied: Array, forces: Array) -> bool:
    """Write the forces (n,) along the guide's coordinates and return whether they are sane."""
    onto_coordinates(rows, applied, forces)
    return sane(body, applied)


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
