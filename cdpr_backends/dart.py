"""DART: one body under our cable wrench, on a free joint or on the joints of its guide."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import dartpy
import numpy as np

from cdpr.model import Robot, rotations
from cdpr.model.body_frame import BodyFrame
from cdpr.model.guide import IntArray, from_coordinates, onto_coordinates
from cdpr.model.jit import kernel
from cdpr.model.kernels import conjugate, exponential, logarithm, multiply, quaternion, store, vector
from cdpr.model.robot import Array
from cdpr.plugins import Backend, RigidBodyBackend
from cdpr_backends.attitude import put_attitude
from cdpr_backends.snapshots import put_back, save

# DART drops forces that are not finite, and where numbers overflow it prints warnings without end and goes on with
# zeros. Above this force, N or N m, or speed, m/s or rad/s, it is not asked to step: the state becomes NaN.
SANE = 1e12

# Links between joints have no mass, but DART warns of less than something. This is lost in the first sum.
NO_MASS = 1e-100


# DART keeps the attitude of a free joint as rotation vector, and its steps are inexact where that is near zero: by 4e-8
# rad after 1 s. DART's body axes are turned by this much in ours, so that an upright platform is far from there.
TURN = exponential((0.6, 0.5, 0.4))


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
        self._home = home = np.zeros(3)  # where the slides measure from
        self.skeleton = skeleton = add_platform(world, frame)
        forces = np.zeros(skeleton.getNumDofs())
        get_q, get_u, push, step = skeleton.getPositions, skeleton.getVelocities, skeleton.setForces, world.step
        if frame.guide is None:
            from_joint: Callable[[Array, Array], None] = partial(read_free_joint, body)
            onto_joint = partial(free_joint_force, body, applied, forces)
        else:
            guide = frame.guide
            from_joint = partial(read_guide, guide.packed, guide.rows, home, body)
            onto_joint = partial(guide_force, guide.rows, body, applied, forces)

        def advance() -> None:
            self._sane = onto_joint()
            if self._sane:
                push(forces)
                step()

        def read() -> None:
            if self._sane:
                from_joint(get_q(), get_u())
            else:
                body[:] = np.nan

        self._advance, self._read = advance, read

    def write(self) -> None:
        """Put the body into `body`."""
        self._sane = True
        self.world.reset()
        guide = self.frame.guide
        if guide is None:
            q, u = np.zeros(6), np.zeros(6)
            write_free_joint(self.body, q, u)
        else:
            self._home[:] = self.body[:3] * (1.0 - guide.packed[:3])
            put_root(self.skeleton, self._home)
            q, u = guide.coordinates(self.body, self._home)
        set_motion(self.skeleton, q, u)

    def read(self) -> None:
        """Read the body into `body`."""
        self._read()

    def advance(self) -> None:
        """Advance by one physics step."""
        self._advance()

    def engine_time(self) -> float:
        """Return DART's time, s."""
        return float(self.world.getTime())

    def snapshot(self) -> object:
        """Return joint coordinates and rates, DART's time and our arrays."""
        motion = self.skeleton.getPositions(), self.skeleton.getVelocities()
        return motion, self.world.getTime(), self._sane, save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Go back to a snapshot."""
        motion, time, self._sane, arrays = snapshot
        put_back(arrays, self.arrays)
        self.world.setTime(time)
        if self.frame.guide is not None:
            put_root(self.skeleton, self._home)
        set_motion(self.skeleton, *motion)

    @property
    def arrays(self) -> tuple[Array, ...]:
        """What a snapshot must hold besides DART's own state."""
        return *super().arrays, self._home


def make_world(gravity: Array, step: float) -> Any:
    """Return an empty world, in which nothing falls asleep."""
    world = dartpy.simulation.World()
    world.setGravity(gravity)
    world.setTimeStep(step)
    sleep = world.getDeactivationOptions()
    sleep.mEnabled = False
    world.setDeactivationOptions(sleep)
    return world


def add_platform(world: Any, frame: BodyFrame) -> Any:
    """Add the platform on its joints and return its skeleton."""
    skeleton = dartpy.dynamics.Skeleton("platform")
    if frame.guide is None:
        _, last = skeleton.createFreeJointAndBodyNodePair()
        axes = rotations.matrix(np.array(conjugate(TURN)))
        last.setInertia(dartpy.dynamics.Inertia(frame.mass, frame.center, axes * frame.moments @ axes.T))
    else:
        axes = rotations.matrix(frame.axes)
        kinds = ["Prismatic"] * len(frame.guide.slides)
        directions = list(frame.guide.slides)
        if frame.guide.hinge is not None:
            kinds.append("Revolute")
            directions.append(frame.guide.hinge)
        chain(skeleton, kinds, np.eye(3)[directions], frame.mass, frame.center, axes * frame.moments @ axes.T)
    world.addSkeleton(skeleton)
    return skeleton


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
def read_free_joint(body: Array, q: Array, u: Array) -> None:
    """Read DART's free joint (rotation vector, position; angular velocity, velocity) into a body state (13,)."""
    put_attitude(multiply(exponential(vector(q, 0)), conjugate(TURN)), body)
    for i in range(3):
        body[i] = q[3 + i]
        body[7 + i] = u[3 + i]
        body[10 + i] = u[i]


@kernel
def write_free_joint(body: Array, q: Array, u: Array) -> None:
    """Undo `read_free_joint`."""
    store(logarithm(multiply(quaternion(body, 3), TURN)), q, 0)
    store(vector(body, 0), q, 3)
    store(vector(body, 10), u, 0)
    store(vector(body, 7), u, 3)


@kernel
def read_guide(guide: Array, rows: IntArray, home: Array, body: Array, q: Array, u: Array) -> None:
    """Read joint coordinates and rates (n,) into a body state (13,)."""
    from_coordinates(guide, rows, home, q, u, body)
