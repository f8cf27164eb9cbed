"""One multibody under the wrench of cdpr's cables, in its own client."""

from __future__ import annotations

from collections.abc import Callable
from struct import Struct
from typing import Any

import numpy as np

from cdpr.mechanics.body_frame import BodyFrame
from cdpr.mechanics.guide import Guide
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import RigidBodyBackend
from cdpr.plugins.backend import Operations, Phases
from cdpr.plugins.inertia import Inertia
from cdpr.plugins.snapshots import put_back, save
from cdpr_backends.bullet.world import (
    BASE,
    SMALLEST,
    TITLE,
    UPRIGHT,
    Client,
    SavedState,
    chain,
    held,
    pybullet,
    undamped,
    xyzw,
)

# Conversion between Python floats and the memory of arrays, in a third of the time of numpy.
put_base, put_joint = Struct("13d").pack_into, Struct("7d").pack_into
get_vector = Struct("3d").unpack_from


class BulletBackend(RigidBodyBackend):
    """Body under the wrench of cdpr's cable kernel. A client costs 29 MB and 20 ms, so call `close` after use."""

    smallest, title = SMALLEST, TITLE

    def build(self) -> None:
        """Build the world."""
        self.client = Client(self.gravity, self.physics_step)
        client = self.client.number
        frame = self.frame
        if frame.guide is None:
            self._plant: Free | Guided | Ball = Free(client, frame.mass, frame.moments, self.body, self.applied)
        elif frame.guide.spherical:
            self._plant = Ball(client, frame, self.body, self.applied)
        else:
            self._plant = Guided(client, frame.guide, frame, self.body, self.applied)

    def write(self) -> None:
        """Set Bullet's body to the state in `body`."""
        self._plant.write()

    def load_body(self) -> None:
        """Give Bullet's body its mass properties and the state in `body`."""
        if isinstance(self._plant, Free):
            self._plant.load_body(self.frame.mass, self.frame.moments)
            return
        # Bullet does not move the centre of mass of a link.
        self.client = Client(self.gravity, self.physics_step)
        self._plant.move_to(self.client.number, self._plant.add(self.client.number))

    def held(self) -> Inertia:
        """Return the inertia of the body in Bullet."""
        return self._plant.held()

    def read(self) -> None:
        """Read Bullet's body into `body`."""
        self._plant.fetch()
        self._plant.publish()

    def push(self) -> None:
        """Write the loads into Bullet."""
        self._plant.load()
        self._plant.push()

    def advance(self) -> None:
        """Advance Bullet by one physics step."""
        self._plant.advance()

    def engine_phases(self) -> Phases:
        """Return the Python operations of Bullet, and the compiled operations before and after them."""
        plant = self._plant
        return Phases([plant.load, plant.push], [plant.advance], [plant.fetch, plant.publish])

    def engine_operations(self) -> Operations:
        """Return the same with one Python operation, in less time."""
        return [self._plant.load, self._plant.move, self._plant.publish]

    def snapshot(self) -> object:
        """Return the state of Bullet and copies of the arrays."""
        return self.client, self._plant.number, SavedState(self.client), save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot."""
        client, number, engine, arrays = snapshot
        if client is not self.client and not isinstance(self._plant, Free):
            self.client = client
            self._plant.use(client.number, number)
        engine.restore()
        put_back(arrays, self.arrays)
        self.read()

    @property
    def arrays(self) -> tuple[Array, ...]:
        """Arrays of a snapshot besides Bullet's own state."""
        return *super().arrays, self._plant.home

    def close(self) -> None:
        """Disconnect the client."""
        self.client.close()


class Plant:
    """Body that Bullet moves. Its inputs and outputs are arrays, so that the surrounding operations are compiled.

    Attributes:
        home: (3,) position of the joints of a guided platform in the world frame.
        client, number, link: Bullet's numbers of the world, the body, and its link with the platform's mass.
        load: operation that writes the loads for Bullet.
        push: function that applies the loads in Bullet.
        advance: function that steps Bullet's world.
        move: function that pushes, advances and fetches.
        fetch: function that gets the pose and the velocities from Bullet.
        publish: operation that writes them into the body state.
    """

    home: Array
    client: int
    number: int
    link: int
    load: Callable[[], object]
    push: Callable[[], None]
    advance: Callable[[], None]
    move: Callable[[], None]
    fetch: Callable[[], None]
    publish: Callable[[], object]

    def held(self) -> Inertia:
        """Return the inertia of the body in Bullet."""
        return held(self.client, self.number, self.link)


class Free(Plant):
    """Free body in Bullet, with its base frame at the centre of mass along the principal axes."""

    def __init__(self, client: int, mass: float, moments: Array, body: Array, applied: Array) -> None:
        self.body, self.home = body, np.zeros(3)
        self.number = number = pybullet.createMultiBody(baseMass=mass, physicsClientId=client)
        pybullet.changeDynamics(number, BASE, localInertiaDiagonal=moments.tolist(), physicsClientId=client)
        undamped(client, number)
        self.client, self.link = client, BASE
        position, velocity = pybullet.getBasePositionAndOrientation, pybullet.getBaseVelocity
        push, turn, step = pybullet.applyExternalForce, pybullet.applyExternalTorque, pybullet.stepSimulation
        world = pybullet.WORLD_FRAME
        base, loads = np.zeros(13), np.zeros(6)
        into, outof = base.data.cast("B"), loads.data.cast("B")
        at = (0.0, 0.0, 0.0)

        def fetch() -> None:
            nonlocal at
            at, q = position(number, client)
            v, w = velocity(number, client)
            put_base(into, 0, *at, *q, *v, *w)

        def apply() -> None:
            push(number, BASE, get_vector(outof, 0), at, world, client)
            turn(number, BASE, get_vector(outof, 24), world, client)

        def advance() -> None:
            step(client)

        def move() -> None:
            push(number, BASE, get_vector(outof, 0), at, world, client)
            turn(number, BASE, get_vector(outof, 24), world, client)
            step(client)
            fetch()

        self.load, self.push = bind("copy", source=applied, target=loads), apply
        self.advance, self.move = advance, move
        self.fetch, self.publish = fetch, bind("bullet_base_state", base=base, body=body)

    def load_body(self, mass: float, moments: Array) -> None:
        """Take mass and moments, and the body state."""
        inertia = moments.tolist()
        pybullet.changeDynamics(self.number, BASE, mass=mass, physicsClientId=self.client)
        pybullet.changeDynamics(self.number, BASE, localInertiaDiagonal=inertia, physicsClientId=self.client)
        self.write()
        self.fetch()

    def write(self) -> None:
        """Set the base to the body state."""
        p, q, v, w = np.split(self.body, [3, 7, 10])
        pybullet.resetBasePositionAndOrientation(self.number, p.tolist(), xyzw(q), self.client)
        pybullet.resetBaseVelocity(self.number, v.tolist(), w.tolist(), self.client)


class Guided(Plant):
    """Fixed base with a chain of links, one per coordinate; the last link is the platform.

    Attributes:
        use: function that takes the numbers of another world and the body in it.
    """

    def __init__(self, client: int, guide: Guide, frame: BodyFrame, body: Array, applied: Array) -> None:
        self.client, self.guide, self.body, self.home = client, guide, body, np.zeros(3)
        self._frame = frame
        kinds = [pybullet.JOINT_PRISMATIC] * len(guide.slides)
        directions = list(guide.slides)
        if guide.hinge is not None:
            kinds.append(pybullet.JOINT_REVOLUTE)
            directions.append(guide.hinge)
        self._kinds, self._directions = kinds, np.eye(3)[directions]
        self.number = number = self.add(client)
        self.joints = joints = list(range(len(kinds)))
        n = len(kinds)
        self.link = n - 1
        q, u, forces = np.zeros(n), np.zeros(n), np.zeros(n)
        positions, rates, push = q.data.cast("B"), u.data.cast("B"), forces.data
        put = Struct(f"{n}d").pack_into
        states, drive, step = pybullet.getJointStates, pybullet.setJointMotorControlArray, pybullet.stepSimulation
        torque = pybullet.TORQUE_CONTROL

        def fetch() -> None:
            found = states(number, joints, client)
            put(positions, 0, *[state[0] for state in found])
            put(rates, 0, *[state[1] for state in found])

        def apply() -> None:
            drive(number, joints, torque, forces=push.tolist(), physicsClientId=client)

        def advance() -> None:
            step(client)

        def move() -> None:
            drive(number, joints, torque, forces=push.tolist(), physicsClientId=client)
            step(client)
            fetch()

        def use(world: int, body: int) -> None:
            nonlocal client, number
            self.client, self.number = client, number = world, body

        self.use, self._coordinates = use, (q, u)
        self.load = bind("guide_forces", rows=guide.rows, applied=applied, forces=forces)
        self.push, self.advance, self.move = apply, advance, move
        self.fetch = fetch
        self.publish = bind(
            "guide_state", guide=guide.packed, rows=guide.rows, home=self.home, coordinate=q, rate=u, body=body
        )

    def add(self, client: int) -> int:
        """Add another such body to a world; return its number."""
        frame = self._frame
        inertia = frame.mass, frame.moments, frame.center.tolist(), xyzw(frame.axes)
        return chain(client, (0.0, 0.0, 0.0), self._kinds, self._directions, *inertia)

    def move_to(self, client: int, number: int) -> None:
        """Continue with another such body, in the same motion."""
        pybullet.resetBasePositionAndOrientation(number, self.home.tolist(), UPRIGHT, client)
        for joint, (q, u) in enumerate(zip(*self._coordinates, strict=True)):
            pybullet.resetJointState(number, joint, q, u, client)
        self.use(client, number)
        self.fetch()

    def write(self) -> None:
        """Set the joints to the body state."""
        self.home[:] = self.body[:3] * (1.0 - self.guide.packed[:3])
        pybullet.resetBasePositionAndOrientation(self.number, self.home.tolist(), UPRIGHT, self.client)
        q, u = self.guide.coordinates(self.body, self.home)
        for joint in self.joints:
            pybullet.resetJointState(self.number, joint, q[joint], u[joint], self.client)


class Ball(Plant):
    """Fixed base with the platform on a spherical joint.

    Bullet requires the axes of a link to be its principal axes, which are those of the platform rotated by `axes`. For
    the attitude q of the platform, the attitude of the joint is axes^-1 q axes. Its rate is along the axes of the link.

    Attributes:
        use: function that takes the numbers of another world and the body in it.
    """

    def __init__(self, client: int, frame: BodyFrame, body: Array, applied: Array) -> None:
        self.client, self.axes, self.body, self.home = client, frame.axes, body, np.zeros(3)
        self.link, self._frame = 0, frame
        self.number = number = self.add(client)
        state, turn, step = pybullet.getJointStateMultiDof, pybullet.applyExternalTorque, pybullet.stepSimulation
        world = pybullet.WORLD_FRAME
        joint, moment = np.zeros(7), np.zeros(3)
        into, outof = joint.data.cast("B"), moment.data.cast("B")

        def fetch() -> None:
            q, w, _, _ = state(number, 0, client)
            put_joint(into, 0, *q, *w)

        def apply() -> None:
            turn(number, 0, get_vector(outof, 0), world, client)

        def advance() -> None:
            step(client)

        def move() -> None:
            turn(number, 0, get_vector(outof, 0), world, client)
            step(client)
            fetch()

        def use(world: int, body: int) -> None:
            nonlocal client, number
            self.client, self.number = client, number = world, body

        self.use = use
        self.load, self.push = bind("copy", source=applied[3:], target=moment), apply
        self.advance, self.move = advance, move
        self.fetch = fetch
        self.publish = bind("bullet_ball_state", home=self.home, axes=self.axes, joint=joint, body=body)

    def add(self, client: int) -> int:
        """Add another such body to a world; return its number."""
        frame = self._frame
        number = int(
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
        return number

    def move_to(self, client: int, number: int) -> None:
        """Continue with another such body, whose link may have other axes, in the same motion."""
        self.use(client, number)
        self.write()
        self.fetch()

    def write(self) -> None:
        """Set the joint to the body state."""
        self.home[:] = self.body[:3]
        pybullet.resetBasePositionAndOrientation(self.number, self.home.tolist(), UPRIGHT, self.client)
        link = rotations.multiply(self.body[3:7], self.axes)
        q = rotations.multiply(rotations.conjugate(self.axes), link)
        w = rotations.matrix(link).T @ self.body[10:]
        pybullet.resetJointStateMultiDof(self.number, 0, xyzw(q), w.tolist(), physicsClientId=self.client)
