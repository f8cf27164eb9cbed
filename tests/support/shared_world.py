"""Free platforms of several robots in one MuJoCo world, each with its own backend."""

from __future__ import annotations

import mujoco
import numpy as np

from cdpr.mechanics.body_frame import BodyFrame
from cdpr.native.bind import bind
from cdpr.plugins import RigidBodyBackend
from cdpr.plugins.backend import Phases
from cdpr_backends.mujoco.direct import direct
from cdpr_backends.mujoco.world import along_body

RADIUS = 0.2  # m, of each platform


class SharedWorld:
    """Spheres on free joints that touch each other."""

    def __init__(self, robots, gravity, step):
        self.frames = [BodyFrame(robot) for robot in robots]
        spec = mujoco.MjSpec()
        spec.option.timestep, spec.option.gravity = step, gravity
        for k, frame in enumerate(self.frames):
            body = spec.worldbody.add_body(name=f"platform_{k}", mass=frame.mass, explicitinertial=True)
            body.inertia = np.full(3, frame.moments.max())  # the exact ones follow
            body.add_freejoint()
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[RADIUS, 0.0, 0.0])
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        for k, frame in enumerate(self.frames):
            self.model.body_inertia[1 + k] = frame.moments
        mujoco.mj_setConst(self.model, self.data)
        self.direct = direct(self.model, self.data)

    def backends(self, robots, gravity, step):
        """Return a backend for each robot."""
        return [SharedBackend(robot, gravity, step, (self, k)) for k, robot in enumerate(robots)]


class SharedBackend(RigidBodyBackend):
    """Platform number `options[1]` in the world `options[0]`."""

    def build(self):
        self.shared_world, k = self.options
        data = self.shared_world.data
        self._q, self._u = data.qpos[7 * k : 7 * k + 7], data.qvel[6 * k : 6 * k + 6]
        self.applied = data.xfrc_applied[1 + k]
        self._read = bind("mujoco_free_state", coordinates=self._q, rates=self._u, body=self.body)

    def write(self):
        self._q[:], self._u[:] = self.body[:7], [*self.body[7:10], *along_body(self.body)]

    def read(self):
        self._read()

    def advance(self):
        mujoco.mj_step(self.shared_world.model, self.shared_world.data)

    def engine_phases(self):
        return Phases([], [self.shared_world.direct.step], [self._read])
