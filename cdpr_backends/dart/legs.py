"""DART with rigid legs as cables."""

from __future__ import annotations

from typing import Any

import dartpy
import numpy as np

from cdpr.native.bind import bind
from cdpr.plugins.inertia import Inertia
from cdpr.plugins.snapshots import put_back, save
from cdpr_backends.dart.joints import FreeJoint
from cdpr_backends.dart.world import SLIMMEST, TITLE, chain, make_world, put_root, set_motion
from cdpr_backends.ups import UpsBackend

ERROR_REDUCTION = 0.2  # share of a loop's gap that a step closes


class DartUps(UpsBackend):
    """Free body on legs closed by ball-joint constraints.

    The joints have no damping in DART, because DART would apply it before it solves the loops.
    """

    slimmest, title = SLIMMEST, TITLE

    def build(self) -> None:
        """Prepare the compiled operation; `write` builds the world."""
        self._forces = np.zeros(6)
        self._load = bind("dart_free_forces", body=self.body, applied=self.applied, forces=self._forces)

    def write(self) -> None:
        """Build the world with the body state in `body`."""
        world = make_world(self.gravity, self.physics_step)
        joint = FreeJoint(world, self.frame, self.body, self.physics_step)
        joint.write()
        platform = joint.skeleton
        skeletons = [platform]
        for i, leg in enumerate(self.legs()):
            skeleton = dartpy.dynamics.Skeleton(f"leg_{i}")
            link = chain(
                skeleton, ["Revolute", "Revolute", "Prismatic"], leg.axes, leg.mass, leg.center, leg.inertia * np.eye(3)
            )
            world.addSkeleton(skeleton)
            put_root(skeleton, leg.anchor)
            set_motion(skeleton, np.zeros(3), leg.rates)
            loop = dartpy.constraint.BallJointConstraint(platform.getBodyNode(0), link, leg.anchor + 2.0 * leg.center)
            loop.setErrorReductionParameter(ERROR_REDUCTION)
            world.getConstraintSolver().addConstraint(loop)
            skeletons.append(skeleton)
        self._use(world, joint, skeletons)

    def _use(self, world: Any, joint: FreeJoint, skeletons: list[Any]) -> None:
        self._world, self._joint, self._skeletons = world, joint, skeletons

    def load_body(self) -> None:
        """Build the world anew, with the legs in the present pose."""
        time = self._world.getTime()
        self.write()
        self._world.setTime(time)

    def held(self) -> Inertia:
        """Return the inertia of the body in DART."""
        return self._joint.held()

    def read(self) -> None:
        """Do nothing; `moved` already reads the body after each step."""

    def advance(self) -> None:
        """Advance by one physics step."""
        self._load()
        if np.isnan(self._forces[0]) or not np.isfinite(self.command).all():
            self.body[:] = np.nan
            return
        self._skeletons[0].setForces(self._forces)
        legs = self._skeletons[1:]
        forces = self.forces(np.array([skeleton.getVelocities() for skeleton in legs]))
        for skeleton, force in zip(legs, forces, strict=True):
            skeleton.setForces(force)
        self._world.step()
        self._joint.moved()

    def engine_time(self) -> float:
        """Return the time of DART [s]."""
        return float(self._world.getTime())

    def snapshot(self) -> object:
        """Return the world, joint coordinates and rates, the time of DART and copies of the arrays."""
        built = self._world, self._joint, self._skeletons, self._joint.kept.copy()
        motion = [(skeleton.getPositions(), skeleton.getVelocities()) for skeleton in self._skeletons]
        return built, motion, self._world.getTime(), save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot."""
        (world, joint, skeletons, kept), motion, time, arrays = snapshot
        self._use(world, joint, skeletons)
        joint.kept[:] = kept
        joint.place()
        world.setTime(time)
        for skeleton, (q, u) in zip(skeletons, motion, strict=True):
            set_motion(skeleton, q, u)
        put_back(arrays, self.arrays)
