"""One body under our cable wrench."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import mujoco

from cdpr.plugins import RigidBodyBackend
from cdpr.plugins.snapshots import put_back, save
from cdpr_backends.mujoco.world import PLATFORM, World, specify


class MujocoBackend(RigidBodyBackend):
    """A body under the wrench of cdpr's cable kernel."""

    def build(self) -> None:
        """Make the world."""
        self._world = world = World(self.frame, specify(self.frame, self.gravity, self.physics_step, "euler"))
        self._read = world.reader(self.body)
        if self.frame.guide is None:
            self.applied = world.data.xfrc_applied[PLATFORM]  # MuJoCo's own array, kept until rewritten
            self._advance: Callable[[], None] = partial(mujoco.mj_step, world.model, world.data)
        else:
            apply = world.applier(self.applied)

            def advance() -> None:
                apply()
                mujoco.mj_step(world.model, world.data)

            self._advance = advance

    def write(self) -> None:
        """Put the body into `body`."""
        self._world.write(self.body)

    def read(self) -> None:
        """Read the body into `body`."""
        self._read()

    def advance(self) -> None:
        """Advance by one physics step."""
        self._advance()

    def engine_time(self) -> float:
        """Return MuJoCo's time, s."""
        return float(self._world.data.time)

    def snapshot(self) -> object:
        """Return MuJoCo's state and our arrays."""
        return self._world.save(), save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Go back to a snapshot."""
        engine, arrays = snapshot
        self._world.put_back(engine)
        put_back(arrays, self.arrays)
