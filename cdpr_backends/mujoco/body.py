"""One body under the wrench of cdpr's cables."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import mujoco

from cdpr.plugins import RigidBodyBackend
from cdpr.plugins.backend import Phases
from cdpr.plugins.inertia import Inertia
from cdpr.plugins.snapshots import put_back, save
from cdpr_backends.mujoco.direct import Direct
from cdpr_backends.mujoco.world import PLATFORM, SLIMMEST, SMALLEST, TITLE, InWorld, World, specify


class MujocoBackend(InWorld, RigidBodyBackend):
    """Body under the wrench of cdpr's cable kernel."""

    smallest, slimmest, title = SMALLEST, SLIMMEST, TITLE

    def build(self) -> None:
        """Build the world."""
        self._first = world = World(self.frame, self.specify())
        self._first_robot = self.robot
        self._general: World | None = None
        self._apply: list[Callable[[], object]] = []
        if self.frame.guide is None:
            self.applied = world.data.xfrc_applied[PLATFORM]  # MuJoCo's array, valid until it is rewritten
        self._use(world)

    def specify(self, *, general: bool = False) -> mujoco.MjSpec:
        """Return the description of the world; a derived backend can add to it."""
        return specify(self.frame, self.gravity, self.physics_step, "euler", general=general)

    def _use(self, world: World) -> None:
        self._world = world
        self._read = world.reader(self.body)
        self._step: Callable[[], None] = partial(mujoco.mj_step, world.model, world.data)
        if self.frame.guide is not None:
            self._step = self._step_world
            self._apply = [world.applier(self.applied)]

    def _step_world(self) -> None:
        mujoco.mj_step(self._world.model, self._world.data)

    @property
    def _direct(self) -> Direct | None:
        return self._first.direct

    def load_body(self) -> None:
        """Give MuJoCo's body its mass properties and the state in `body`.

        A diagonal mass matrix is valid for the first platform only; others move in a second world.
        """
        if self._first.diagonal:
            self._change_world()
        self._world.load(self.body)

    def _change_world(self) -> None:
        if self._general is None:
            self._general = World(self.frame, self.specify(general=True))
        same = self.robot.inertial.tobytes() == self._first_robot.inertial.tobytes()
        world = self._first if same else self._general
        if world is not self._world:
            world.continue_from(self._world)
            self._use(world)
            if self._first.direct is not None and world.direct is not None:
                self._first.direct.point_to(world.direct)

    def held(self) -> Inertia:
        """Return the inertia of the body in MuJoCo."""
        return self._world.held()

    def write(self) -> None:
        """Set MuJoCo's body to the state in `body`."""
        self._world.write(self.body)

    def read(self) -> None:
        """Read MuJoCo's body into `body`."""
        self._read()

    def push(self) -> None:
        """Write the wrench of a guided platform into MuJoCo."""
        for apply in self._apply:
            apply()

    def advance(self) -> None:
        """Advance MuJoCo by one physics step."""
        self._step()

    def engine_phases(self) -> Phases:
        """Return the step and the operations before and after it, all compiled if MuJoCo can be called directly."""
        direct = self._direct
        return Phases([*self._apply], [self._step if direct is None else direct.step], [self._read])

    def snapshot(self) -> object:
        """Return the state of MuJoCo and copies of the arrays."""
        return self._world.save(), save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot."""
        engine, arrays = snapshot
        self._world.put_back(engine)
        put_back(arrays, self.arrays)
