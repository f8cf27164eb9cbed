"""Scheme of the engines: semi-implicit Euler, first order, with one evaluation of the cables per step.

`cdpr compare` runs it beside an engine that declares this scheme. Their difference is then due to the adapter of the
engine, not to the step size.
"""

from __future__ import annotations

import numpy as np

from cdpr.mechanics.spherical import pack
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import RigidBodyBackend
from cdpr.plugins.backend import Operations
from cdpr.plugins.snapshots import SnapshotOfArrays


class SemiImplicitEuler(SnapshotOfArrays, RigidBodyBackend):
    """Semi-implicit Euler scheme: new velocities first, then the pose from them.

    The velocities come from the accelerations at the start of the step.
    """

    def build(self) -> None:
        """Bind the kernel for a free or a guided platform."""
        frame = self.frame
        self._motion = np.zeros(8)  # with a guide: position, angle, velocity, angular rate
        given = {"gravity": self.gravity, "applied": self.applied, "body": self.body, "step": self.physics_step}
        self._inertial = inertial = self._mass_properties()
        if frame.guide is None:
            self._advance = bind("euler_free_step", inertial=inertial, **given)
        elif frame.guide.spherical:
            self._advance = bind("euler_spherical_step", packed=inertial, **given)
        else:
            guide = frame.guide.packed
            self._advance = bind("euler_guided_step", guide=guide, inertial=inertial, motion=self._motion, **given)

    def _mass_properties(self) -> Array:
        """Return the mass properties in the layout of the kernel."""
        frame = self.frame
        if frame.guide is None:
            return np.array([frame.mass, *frame.moments])
        return pack(self.robot) if frame.guide.spherical else self.robot.inertial.copy()

    def load_body(self) -> None:
        """Take the mass properties; the motion is already in `body`, or in the coordinates of the guide."""
        self._inertial[:] = self._mass_properties()

    def write(self) -> None:
        """Set the motion from `body`."""
        guide = self.frame.guide
        if guide is not None and guide.spherical:
            self.body[7:10] = 0.0
        elif guide is not None:
            free, axis = guide.packed[:3], guide.packed[3:]
            self._motion[:3], self._motion[3] = self.body[:3], guide.angle(self.body)
            self._motion[4:7], self._motion[7] = free * self.body[7:10], axis @ self.body[10:]

    def read(self) -> None:
        """Do nothing; the motion is already in `body`."""

    def advance(self) -> None:
        """Advance by one physics step."""
        self._advance()

    def engine_operations(self) -> Operations:
        """Return the integrator."""
        return [self._advance]

    @property
    def arrays(self) -> tuple[Array, ...]:  # type: ignore[override]  # a property of one base, an attribute of the other
        """Arrays of a snapshot."""
        return *super().arrays, self._motion
