"""DART with rigid legs as cables."""

from __future__ import annotations

from typing import Any

import dartpy
import numpy as np

from cdpr_backends.dart import (
    add_platform,
    chain,
    free_joint_force,
    make_world,
    put_root,
    read_free_joint,
    set_motion,
    write_free_joint,
)
from cdpr_backends.snapshots import put_back, save
from cdpr_backends.ups import UpsBackend

ERROR_REDUCTION = 0.2  # share of a loop's gap that a step closes


class DartUps(UpsBackend):
    """A free body on legs closed by ball joint constraints.

    The joints have no damping of DART's: it would take its share of the pull before the loops are solved.
    """

    def build(self) -> None:
        """Leave the world to `write`."""
        self._forces = np.zeros(6)

    def write(self) -> None:
        """Make the world with the body in `body`."""
        self._sane = True
        world = make_world(self.gravity, self.physics_step)
        platform = add_platform(world, self.frame)
        q, u = np.zeros(6), np.zeros(6)
        write_free_joint(self.body, q, u)
        set_motion(platform, q, u)
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
        self._use(world, skeletons)

    def _use(self, world: Any, skeletons: list[Any]) -> None:
        self._world, self._skeletons = world, skeletons

    def read(self) -> None:
        """Read the body into `body`."""
        if self._sane:
            platform = self._skeletons[0]
            read_free_joint(self.body, platform.getPositions(), platform.getVelocities())
        else:
            self.body[:] = np.nan

    def advance(self) -> None:
        """Advance by one physics step."""
        self._sane = free_joint_force(self.body, self.applied, self._forces) and bool(np.isfinite(self.command).all())
        if not self._sane:
            return
        self._skeletons[0].setForces(self._forces)
        legs = self._skeletons[1:]
        forces = self.forces(np.array([skeleton.getVelocities() for skeleton in legs]))
        for skeleton, force in zip(legs, forces, strict=True):
            skeleton.setForces(force)
        self._world.step()

    def engine_time(self) -> float:
        """Return DART's time, s."""
        return float(self._world.getTime())

    def snapshot(self) -> object:
        """Return the world as it was built, joint coordinates and rates, DART's time and our arrays."""
        motion = [(skeleton.getPositions(), skeleton.getVelocities()) for skeleton in self._skeletons]
        return self._world, self._skeletons, motion, self._world.getTime(), self._sane, save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Go back to a snapshot."""
        world, skeletons, motion, time, self._sane, arrays = snapshot
        self._use(world, skeletons)
        world.setTime(time)
        for skeleton, (q, u) in zip(skeletons, motion, strict=True):
            set_motion(skeleton, q, u)
        put_back(arrays, self.arrays)
