"""MuJoCo with the obstacles of a scenario as bodies that the platform touches."""

from __future__ import annotations

from types import MappingProxyType

import mujoco
import numpy as np

from cdpr.model import Box, Sphere, rotations
from cdpr.native.bind import bind
from cdpr.plugins import Column, Environment
from cdpr_backends.mujoco.body import MujocoBackend

KINDS = {Box: mujoco.mjtGeom.mjGEOM_BOX, Sphere: mujoco.mjtGeom.mjGEOM_SPHERE}


class Touching(MujocoBackend):
    """MuJoCo with contact between a free platform, a box or a sphere, and the obstacles."""

    properties = MappingProxyType({"order": 1, "snapshot": True, "surroundings": ["obstacles"]})
    columns = (Column("touch", 3, "N", "Force of the obstacles on the platform", "world"),)
    environment = Environment()

    def surround(self, environment):
        self.environment = environment
        self.assemble()

    def specify(self, *, general=False):
        spec = super().specify(general=general)
        if not self.environment.obstacles:
            return spec
        spec.option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
        shape, offset = self.robot.platform.shape, self.frame.offset  # of the body frame in that of the shape
        platform = spec.body("platform").add_geom(type=KINDS[type(shape)], size=extent(shape))
        platform.pos, platform.quat = -offset[:3], rotations.conjugate(offset[3:])
        for each in self.environment.obstacles:
            kind, size = KINDS[type(each.shape)], extent(each.shape)
            spec.worldbody.add_geom(type=kind, size=size, pos=each.position, quat=each.attitude)
        return spec

    def log(self, columns):
        self.touch = columns["touch"]

    def write(self):
        super().write()
        self.touch[:] = 0.0

    def read(self):
        super().read()
        self.touch[:] = self._world.data.qfrc_constraint[:3]

    def engine_phases(self):
        phases = super().engine_phases()
        touched = bind("copy", source=self._world.data.qfrc_constraint[:3], target=self.touch)
        return phases._replace(read=[*phases.read, touched])


def extent(shape):
    """Return the sizes of MuJoCo's geom."""
    return 0.5 * np.array(shape.size) if isinstance(shape, Box) else [shape.radius, 0.0, 0.0]
