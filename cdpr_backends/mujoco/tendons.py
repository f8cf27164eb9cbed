"""One body with MuJoCo's spatial tendons as cables."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from cdpr.mechanics.body_frame import BodyFrame, body_state
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins.inertia import check_held, check_range
from cdpr.plugins.snapshots import put_back, save
from cdpr_backends.mujoco.world import SLIMMEST, SMALLEST, TITLE, InWorld, World, specify


class MujocoTendons(InWorld):
    """Body on spatial tendons: MuJoCo evaluates the cables at every stage of its integrator."""

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.frame = frame = BodyFrame(robot)
        check_range(frame, TITLE, SMALLEST, SLIMMEST)
        spec = specify(frame, self.gravity, physics_step, options.integrator)
        add_tendons(spec, frame.anchors)
        self._staged = options.integrator == "rk4"
        if self._staged:
            add_wrench(spec, -frame.offset[:3])
        self._world = World(frame, spec)
        check_held(frame, self._world.held(), TITLE)
        self._body = np.zeros(13)
        self._applied = np.zeros(6)
        self._weigh = bind(
            "applied_wrench",
            lines=frame.line_table,
            offset=frame.offset,
            tension=np.zeros(robot.m),  # the tendons already pull
            external=self.external,
            body=self._body,
            applied=self._applied,
        )
        self._to_platform = bind("platform_state", offset=frame.offset, body=self._body, state=self.state)
        self._read = self._world.reader(self._body)
        self._apply = self._world.applier(self._applied)
        self._bad_command = self._world.data.warning[mujoco.mjtWarning.mjWARN_BADCTRL]

    def reset(self, state: Array) -> None:
        """Set the platform to `state` (13,)."""
        self._body[:] = body_state(self.frame.offset, state)
        self._world.write(self._body)
        self._publish()

    def load(self, robot: Robot) -> None:
        """Move another platform from now on, with the same pose and twist of its origin."""
        self.robot, frame, model = robot, self.frame, self._world.model
        frame.refill(robot)
        check_range(frame, TITLE, SMALLEST, SLIMMEST)
        for i, row in enumerate(frame.anchors):
            model.site(f"platform_{i}").pos = row[3:]
        if self._staged:
            model.site("origin").pos = -frame.offset[:3]
        self._body[:] = body_state(frame.offset, self.state)
        self._world.load(self._body)
        check_held(frame, self._world.held(), TITLE)
        self._read()

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        world = self._world
        world.data.ctrl[: self.robot.m] = self.command
        if self._staged:
            world.data.ctrl[self.robot.m :] = self.external
            mujoco.mj_step(world.model, world.data, n)
        elif self.external.any() or self._applied.any():
            for _ in range(n):  # the external wrench moves with the platform
                self._read()
                self._weigh()
                self._apply()
                mujoco.mj_step(world.model, world.data)
        else:
            mujoco.mj_step(world.model, world.data, n)
        self._publish()
        if self._bad_command.number:  # MuJoCo has replaced the commands by zeros
            self._bad_command.number = 0
            self.state[:] = np.nan

    def snapshot(self) -> object:
        """Return the state of MuJoCo and copies of the arrays."""
        return self._world.save(), save(self._arrays)

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot."""
        engine, arrays = snapshot
        self._world.put_back(engine)
        put_back(arrays, self._arrays)

    @property
    def _arrays(self) -> tuple[Array, ...]:
        return self.command, self.external, self._applied, self._body, self.state

    def _publish(self) -> None:
        self._read()
        self._to_platform()


def add_tendons(spec: mujoco.MjSpec, anchors: Array) -> None:
    """Add one tendon and one force actuator per cable, with a gear of -1 because a positive tendon force pushes."""
    for i, row in enumerate(anchors):
        spec.worldbody.add_site(name=f"frame_{i}", pos=row[:3])
        spec.body("platform").add_site(name=f"platform_{i}", pos=row[3:])
        tendon = spec.add_tendon(name=f"cable_{i}")
        tendon.wrap_site(f"frame_{i}")
        tendon.wrap_site(f"platform_{i}")
        actuator = spec.add_actuator(name=f"cable_{i}", target=f"cable_{i}", trntype=mujoco.mjtTrn.mjTRN_TENDON)
        actuator.gear[0] = -1.0


def add_wrench(spec: mujoco.MjSpec, origin: Array) -> None:
    """Add six actuators, forces and moments in world axes at the platform's origin (3,) [m] in the body frame.

    MuJoCo evaluates them at every stage. An applied wrench would keep its moment about the centre of mass for a whole
    step.
    """
    spec.worldbody.add_site(name="world")
    spec.body("platform").add_site(name="origin", pos=origin)
    for axis in range(6):
        actuator = spec.add_actuator(
            name=f"wrench_{axis}", target="origin", refsite="world", trntype=mujoco.mjtTrn.mjTRN_SITE
        )
        actuator.gear[:] = np.eye(6)[axis]
