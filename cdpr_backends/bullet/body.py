"""One multibody under our cable wrench, in a client of its own."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from cdpr.mechanics.body_frame import BodyFrame
from cdpr.mechanics.guide import Guide, from_coordinates, onto_coordinates
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.plugins import RigidBodyBackend
from cdpr.plugins.snapshots import put_back, save
from cdpr_backends.bullet.kernels import read_ball, read_base
from cdpr_backends.bullet.world import BASE, UPRIGHT, Client, SavedState, chain, pybullet, undamped, xyzw


class BulletBackend(RigidBodyBackend):
    """A body under the wrench of cdpr's cable kernel. A client costs 29 MB and 20 ms: `close` it."""

    def build(self) -> None:
        """Make the world."""
        self.client = Client(self.gravity, self.physics_step)
        client = self.client.number
        frame = self.frame
        if frame.guide is None:
            self._plant: Free | Guided | Ball = Free(client, frame.mass, frame.moments, self.body, self.applied)
        elif frame.guide.spherical:
            self._plant = Ball(client, frame, self.body, self.applied)
        else:
            self._plant = Guided(
                client, frame.guide, frame.mass, frame.moments, frame.center, frame.axes, self.body, self.applied
            )
        self._advance, self._read = self._plant.advance, self._plant.read

    def write(self) -> None:
        """Put the body into `body`."""
        self._plant.write()

    def read(self) -> None:
        """Read the body into `body`."""
        self._read()

    def advance(self) -> None:
        """Advance by one physics step."""
        self._advance()

    def snapshot(self) -> object:
        """Return Bullet's state and our arrays."""
        return SavedState(self.client), save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Go back to a snapshot."""
        engine, arrays = snapshot
        engine.restore()
        put_back(arrays, self.arrays)
        self.read()

    @property
    def arrays(self) -> tuple[Array, ...]:
        """What a snapshot must hold besides Bullet's own state."""
        return *super().arrays, self._plant.home

    def close(self) -> None:
        """Disconnect the client."""
        self.client.close()


class Free:
    """A free body in Bullet: its base frame is at the centre of mass, on the principal axes."""

    def __init__(self, client: int, mass: float, moments: Array, body: Array, applied: Array) -> None:
        self.body, self.home = body, np.zeros(3)
        self.number = number = pybullet.createMultiBody(baseMass=mass, physicsClientId=client)
        pybullet.changeDynamics(number, BASE, localInertiaDiagonal=moments.tolist(), physicsClientId=client)
        undamped(client, number)
        self.client = client
        position, velocity = pybullet.getBasePositionAndOrientation, pybullet.getBaseVelocity
        push, turn, step = pybullet.applyExternalForce, pybullet.applyExternalTorque, pybullet.stepSimulation
        world = pybullet.WORLD_FRAME
        at = (0.0, 0.0, 0.0)

        def read() -> None:
            nonlocal at
            pose = position(number, client)
            at = pose[0]
            read_base(pose, velocity(number, client), body)

        def advance() -> None:
            fx, fy, fz, mx, my, mz = applied.tolist()
            push(number, BASE, (fx, fy, fz), at, world, client)
            turn(number, BASE, (mx, my, mz), world, client)
            step(client)

        self.read, self.advance = read, advance

    def write(self) -> None:
        """Put the base into the body state."""
        p, q, v, w = np.split(self.body, [3, 7, 10])
        pybullet.resetBasePositionAndOrientation(self.number, p.tolist(), xyzw(q), self.client)
        pybullet.resetBaseVelocity(self.number, v.tolist(), w.tolist(), self.client)


class Guided:
    """A fixed base, and on it a chain of links, one per coordinate; the last one is the platform."""

    def __init__(
        self,
        client: int,
        guide: Guide,
        mass: float,
        moments: Array,
        center: Array,
        axes: Array,
        body: Array,
        applied: Array,
    ) -> None:
        self.client, self.guide, self.body, self.home = client, guide, body, np.zeros(3)
        kinds = [pybullet.JOINT_PRISMATIC] * len(guide.slides)
        directions = list(guide.slides)
        if guide.hinge is not None:
            kinds.append(pybullet.JOINT_REVOLUTE)
            directions.append(guide.hinge)
        self.number = number = chain(
            client, (0.0, 0.0, 0.0), kinds, np.eye(3)[directions], mass, moments, center.tolist(), xyzw(axes)
        )
        self.joints = joints = list(range(len(kinds)))
        q, u, forces = np.zeros(len(kinds)), np.zeros(len(kinds)), np.zeros(len(kinds))
        states, drive, step = pybullet.getJointStates, pybullet.setJointMotorControlArray, pybullet.stepSimulation
        torque = pybullet.TORQUE_CONTROL
        publish: Callable[[], None] = partial(from_coordinates, guide.packed, guide.rows, self.home, q, u, body)

        def read() -> None:
            for k, (angle, rate, _, _) in enumerate(states(number, joints, client)):
                q[k], u[k] = angle, rate
            publish()

        def advance() -> None:
            onto_coordinates(guide.rows, applied, forces)
            drive(number, joints, torque, forces=forces.tolist(), physicsClientId=client)
            step(client)

        self.read, self.advance = read, advance

    def write(self) -> None:
        """Put the joints into the body state."""
        self.home[:] = self.body[:3] * (1.0 - self.guide.packed[:3])
        pybullet.resetBasePositionAndOrientation(self.number, self.home.tolist(), UPRIGHT, self.client)
        q, u = self.guide.coordinates(self.body, self.home)
        for joint in self.joints:
            pybullet.resetJointState(self.number, joint, q[joint], u[joint], self.client)


class Ball:
    """A fixed base, and on it the platform on a spherical joint.

    Bullet takes the axes of a link to be the principal ones, those of the platform turned by `axes`: the joint's
    attitude is axes^-1 q axes for that of the platform, q, and its rate is along the link's axes.
    """

    def __init__(self, client: int, frame: BodyFrame, body: Array, applied: Array) -> None:
        self.client, self.axes, self.body, self.home = client, frame.axes, body, np.zeros(3)
        self.number = number = int(
            pybullet.createMultiBody(
                baseMass=0.0,
                linkMasses=[frame.mass],
                linkCollisionShapeIndices=[-1],
                linkVisualShapeIndices=[-1],
                linkPositions=[[0.0, 0.0, 0.0]],
                linkOrientations=[UPRIGHT],
                linkInertialFramePositions=[frame.center.tolist()],
                linkInertialFrameOrientations=[xyzw(frame.axes)],
                linkParentIndices=[0],
                linkJointTypes=[pybullet.JOINT_SPHERICAL],
                linkJointAxis=[[0.0, 0.0, 1.0]],
                physicsClientId=client,
            )
        )
        pybullet.changeDynamics(number, 0, localInertiaDiagonal=frame.moments.tolist(), physicsClientId=client)
        pybullet.setJointMotorControlMultiDof(
            number, 0, pybullet.POSITION_CONTROL, targetPosition=UPRIGHT, force=[0.0] * 3, physicsClientId=client
        )
        undamped(client, number)
        state, turn, step = pybullet.getJointStateMultiDof, pybullet.applyExternalTorque, pybullet.stepSimulation
        world, axes, home = pybullet.WORLD_FRAME, self.axes, self.home

        def read() -> None:
            q, w, _, _ = state(number, 0, client)
            read_ball(home, axes, q, w, body)

        def advance() -> None:
            turn(number, 0, applied[3:].tolist(), world, client)
            step(client)

        self.read, self.advance = read, advance

    def write(self) -> None:
        """Put the joint into the body state."""
        self.home[:] = self.body[:3]
        pybullet.resetBasePositionAndOrientation(self.number, self.home.tolist(), UPRIGHT, self.client)
        link = rotations.multiply(self.body[3:7], self.axes)
        q = rotations.multiply(rotations.conjugate(self.axes), link)
        w = rotations.matrix(link).T @ self.body[10:]
        pybullet.resetJointStateMultiDof(self.number, 0, xyzw(q), w.tolist(), physicsClientId=self.client)
