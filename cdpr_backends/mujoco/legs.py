"""MuJoCo with rigid legs as cables."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from cdpr.plugins.inertia import Inertia
from cdpr.plugins.snapshots import put_back, save
from cdpr_backends.mujoco.world import PLATFORM, SLIMMEST, SMALLEST, TITLE, World, specify
from cdpr_backends.ups import Leg, UpsBackend

# Time constant of the loops, the smallest that MuJoCo allows. With its default of 20 ms, the platform is lost after 1.4
# s.
TIME_CONSTANT = 2.0  # [steps]
IMPEDANCE = (0.9999, 0.99999, 0.001, 0.5, 2.0)


class MujocoUps(UpsBackend):
    """Free body on legs closed by `connect` constraints."""

    smallest, slimmest, title = SMALLEST, SLIMMEST, TITLE

    def build(self) -> None:
        """Do nothing; `write` builds the world."""

    def write(self) -> None:
        """Build the world with the body state in `body`."""
        spec = specify(self.frame, self.gravity, self.physics_step, "euler")
        platform = spec.body("platform")
        platform.pos, platform.quat = self.body[:3], self.body[3:7]
        legs = self.legs()
        for i, leg in enumerate(legs):
            add_leg(spec, i, leg, self.physics_step)
        world = World(self.frame, spec)
        world.write(self.body)
        world.data.qvel[6:] = np.concatenate([leg.rates for leg in legs])
        self._use(world)

    def _use(self, world: World) -> None:
        self._world = world
        count = self.robot.m
        # after the six coordinates of the platform
        self._joint_forces = world.data.qfrc_applied[6:].reshape(count, 3)
        self._joint_rates = world.data.qvel[6:].reshape(count, 3)
        self._wrench = world.data.xfrc_applied[PLATFORM]
        self._read = world.reader(self.body)

    def load_body(self) -> None:
        """Build the world anew, with the legs in the present pose."""
        time = self._world.data.time
        self.write()
        self._world.data.time = time

    def held(self) -> Inertia:
        """Return the inertia of the body in MuJoCo."""
        return self._world.held()

    def read(self) -> None:
        """Read MuJoCo's body into `body`."""
        self._read()

    def push(self) -> None:
        """Write the wrench and the joint forces of the legs into MuJoCo."""
        self._joint_forces[:] = self.forces(self._joint_rates)
        self._wrench[:] = self.applied

    def advance(self) -> None:
        """Advance MuJoCo by one physics step."""
        mujoco.mj_step(self._world.model, self._world.data)

    def engine_time(self) -> float:
        """Return the time of MuJoCo [s]."""
        return float(self._world.data.time)

    def snapshot(self) -> object:
        """Return the world, its state and copies of the arrays."""
        return self._world, self._world.save(), save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot."""
        world, engine, arrays = snapshot
        self._use(world)
        world.put_back(engine)
        put_back(arrays, self.arrays)


def add_leg(spec: mujoco.MjSpec, i: int, leg: Leg, step: float) -> None:
    """Add leg i and connect it to the platform."""
    link = spec.worldbody.add_body(name=f"leg_{i}", pos=leg.anchor, mass=leg.mass, explicitinertial=True)
    link.ipos, link.inertia = leg.center, [leg.inertia] * 3
    for kind, axis in zip(("HINGE", "HINGE", "SLIDE"), leg.axes, strict=True):
        link.add_joint(type=getattr(mujoco.mjtJoint, f"mjJNT_{kind}"), axis=axis)
    loop = spec.add_equality(
        type=mujoco.mjtEq.mjEQ_CONNECT, objtype=mujoco.mjtObj.mjOBJ_BODY, name1="platform", name2=f"leg_{i}"
    )
    loop.data[:3] = leg.tip
    loop.solref[:] = TIME_CONSTANT * step, 1.0
    loop.solimp[:] = IMPEDANCE
