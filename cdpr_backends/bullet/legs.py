"""PyBullet with rigid legs as cables."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.plugins.inertia import Inertia
from cdpr.plugins.snapshots import put_back, save
from cdpr_backends.bullet.body import Free
from cdpr_backends.bullet.world import SMALLEST, TITLE, UPRIGHT, Client, SavedState, chain, pybullet
from cdpr_backends.ups import Leg, UpsBackend

UNIVERSAL_SLIDE = (pybullet.JOINT_REVOLUTE, pybullet.JOINT_REVOLUTE, pybullet.JOINT_PRISMATIC)
JOINTS = (0, 1, 2)
SLIDE = 2  # index of the slide
STRONG = 1e9  # [N], largest force of a loop
ITERATIONS = 50  # iterations of the solver that closes the loops, for an error of 4e-7 m


class BulletUps(UpsBackend):
    """Free body on legs closed by point-to-point constraints.

    Each `write` opens a new client, which costs 20 ms, because a cleared client does not give bit-identical results.
    """

    smallest, title = SMALLEST, TITLE

    def build(self) -> None:
        """Do nothing; `write` builds the world."""

    def write(self) -> None:
        """Build the world with the body state in `body`."""
        client = Client(self.gravity, self.physics_step)
        pybullet.setPhysicsEngineParameter(numSolverIterations=ITERATIONS, physicsClientId=client.number)
        platform = Free(client.number, self.frame.mass, self.frame.moments, self.body, self.applied)
        platform.write()
        self._use(client, platform, [add_leg(client.number, platform.number, leg) for leg in self.legs()])

    def _use(self, client: Client, platform: Free, legs: list[int]) -> None:
        self._client, self._platform, self._legs = client, platform, legs

    def load_body(self) -> None:
        """Build the world anew, with the legs in the present pose."""
        self.write()

    def held(self) -> Inertia:
        """Return the inertia of the body in Bullet."""
        return self._platform.held()

    def read(self) -> None:
        """Read Bullet's body into `body`."""
        self._platform.fetch()
        self._platform.publish()

    def push(self) -> None:
        """Write the wrench and the joint forces of the legs into Bullet."""
        client = self._client.number
        rates = [[state[1] for state in pybullet.getJointStates(leg, JOINTS, client)] for leg in self._legs]
        for leg, forces in zip(self._legs, self.forces(np.array(rates)).tolist(), strict=True):
            for joint, force in zip(JOINTS, forces, strict=True):
                pybullet.setJointMotorControl2(leg, joint, pybullet.TORQUE_CONTROL, force=force, physicsClientId=client)
        self._platform.load()
        self._platform.push()

    def advance(self) -> None:
        """Advance Bullet by one physics step."""
        self._platform.advance()

    def snapshot(self) -> object:
        """Return the world, the state of Bullet and copies of the arrays."""
        return (self._client, self._platform, self._legs), SavedState(self._client), save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot."""
        world, engine, arrays = snapshot
        self._use(*world)
        engine.restore()
        put_back(arrays, self.arrays)
        self.read()

    def close(self) -> None:
        """Close the client."""
        self._client.close()


def add_leg(client: int, platform: int, leg: Leg) -> int:
    """Add a leg, connect it to the platform and return its number."""
    moments, center = np.full(3, leg.inertia), leg.center.tolist()
    number = chain(client, leg.anchor.tolist(), UNIVERSAL_SLIDE, leg.axes, leg.mass, moments, center, UPRIGHT)
    for joint, rate in enumerate(leg.rates.tolist()):
        pybullet.resetJointState(number, joint, 0.0, rate, client)
    loop = pybullet.createConstraint(
        platform,
        -1,
        number,
        SLIDE,
        pybullet.JOINT_POINT2POINT,
        [0.0, 0.0, 0.0],
        leg.tip.tolist(),
        center,  # tip relative to the leg's centre
        physicsClientId=client,
    )
    pybullet.changeConstraint(loop, maxForce=STRONG, physicsClientId=client)
    return number
