"""One body under the wrench of cdpr's cables, on a free joint, a spherical joint or the joints of its guide."""

from __future__ import annotations

from collections.abc import Callable
from math import isnan
from typing import Any

import numpy as np

from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import RigidBodyBackend
from cdpr.plugins.backend import Operations, Phases
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
        set_forces, step, moved, get_time = self.joints.push, world.step, self.joints.moved, world.getTime
        self._time = np.zeros(1)
        first, time = forces.data, self._time.data

        def push() -> None:
            if not isnan(first[0]):
                set_forces(forces)

        def fetch() -> None:
            if isnan(first[0]):
                body[:] = np.nan
            else:
                moved()
            time[0] = get_time()

        def dart() -> None:  # in one call, which is quicker
            if isnan(first[0]):
                body[:] = np.nan
            else:
                set_forces(forces)
                step()
                moved()
            time[0] = get_time()

        self._push, self._fetch, self._dart = push, fetch, dart
        self._pushed = False  # and not yet read, by Python

    def write(self) -> None:
        """Set DART's body to the state in `body`."""
        self.world.reset()
        self.joints.write()
        self._pushed = False

    def load_body(self) -> None:
        """Give DART's body its mass properties and the state in `body`."""
        self.joints.load()

    def held(self) -> Inertia:
        """Return the inertia of the body in DART."""
        return self.joints.held()

    def read(self) -> None:
        """Read DART's body into `body` after a step; `write` leaves it there."""
        if self._pushed:
            self._fetch()
            self._pushed = False

    def push(self) -> None:
        """Write the forces of the joints into DART."""
        self._load()
        self._push()
        self._pushed = True

    def advance(self) -> None:
        """Advance DART by one physics step."""
        self.world.step()

    def engine_phases(self) -> Phases:
        """Return the compiled operation before the step of DART, and the Python operations of DART."""
        return Phases([self._load, self._push], [self.world.step], [self._fetch])

    def engine_operations(self) -> Operations:
        """Return the same with one Python operation."""
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
