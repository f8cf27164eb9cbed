"""One body under the wrench of cdpr's cables, on a free joint, a spherical joint or the joints of its guide."""

from __future__ import annotations

from collections.abc import Callable
from math import isnan
from typing import Any

import numpy as np

from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import RigidBodyBackend
from cdpr.plugins.backend import Operations
from cdpr.plugins.inertia import Inertia
from cdpr.plugins.snapshots import put_back, save
from cdpr_backends.dart.joints import BallJoint, FreeJoint, GuideJoints
from cdpr_backends.dart.world import SLIMMEST, TITLE, make_world, set_motion


class DartBackend(RigidBodyBackend):
    """Body under the wrench of cdpr's cable kernel."""

    slimmest, title = SLIMMEST, TITLE

    def build(self) -> None:
        """Build the world."""
        self.world = world = make_world(self.gravity, self.physics_step)
        frame, body, applied = self.frame, self.body, self.applied
        self.joints: FreeJoint | BallJoint | GuideJoints
        if frame.guide is None:
            self.joints = FreeJoint(world, frame, body, self.physics_step)
            forces = np.zeros(6)
            self._load: Callable[[], object] = bind("dart_free_forces", body=body, applied=applied, forces=forces)
        elif frame.guide.spherical:
            self.joints = BallJoint(world, frame, body, self.physics_step)
            forces = np.zeros(3)
            self._load = bind("dart_ball_forces", kept=self.joints.kept, body=body, applied=applied, forces=forces)
        else:
            self.joints = GuideJoints(world, frame, frame.guide, body)
            forces = np.zeros(self.joints.skeleton.getNumDofs())
            self._load = bind("dart_guide_forces", rows=frame.guide.rows, body=body, applied=applied, forces=forces)
        push, step, moved, get_time = self.joints.push, world.step, self.joints.moved, world.getTime
        self._time = np.zeros(1)
        first, time = forces.data, self._time.data

        def dart() -> None:
            if isnan(first[0]):
                body[:] = np.nan
            else:
                push(forces)
                step()
                moved()
            time[0] = get_time()

        self._dart = dart

    def write(self) -> None:
        """Set DART's body to the state in `body`."""
        self.world.reset()
        self.joints.write()

    def load_body(self) -> None:
        """Give DART's body its mass properties and the state in `body`."""
        self.joints.load()

    def held(self) -> Inertia:
        """Return the inertia of the body in DART."""
        return self.joints.held()

    def read(self) -> None:
        """Do nothing; `moved` already reads the body after each step."""

    def advance(self) -> None:
        """Advance by one physics step."""
        self._load()
        self._dart()

    def engine_operations(self) -> Operations:
        """Return the compiled operation before the step of DART, and the step as one Python operation."""
        return [self._load, self._dart]

    def engine_time(self) -> float:
        """Return the time of DART [s]."""
        return float(self.world.getTime())

    def clock_act(self, clock: Array) -> Callable[[], object]:
        """Return the operation that copies the time of DART after its last step into `clock` (1,)."""
        return bind("copy", source=self._time, target=clock)

    def snapshot(self) -> object:
        """Return joint coordinates and rates, the time of DART and copies of the arrays."""
        skeleton = self.joints.skeleton
        return (skeleton.getPositions(), skeleton.getVelocities()), self.world.getTime(), save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot."""
        coordinates, time, arrays = snapshot
        put_back(arrays, self.arrays)
        self.world.setTime(time)
        self.joints.place()
        set_motion(self.joints.skeleton, *coordinates)

    @property
    def arrays(self) -> tuple[Array, ...]:
        """Arrays of a snapshot besides DART's own state."""
        return *super().arrays, self.joints.kept
