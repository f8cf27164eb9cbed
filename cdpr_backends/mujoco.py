"""MuJoCo: one body under our cable wrench, or with MuJoCo's own spatial tendons as cables."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import mujoco
import numpy as np

from cdpr.model import Robot
from cdpr.model.body_frame import BodyFrame, applied_wrench, from_platform, to_platform
from cdpr.model.guide import from_coordinates, onto_coordinates
from cdpr.model.jit import kernel
from cdpr.model.kernels import conjugate, quaternion, rotate, store, vector
from cdpr.model.robot import Array
from cdpr.plugins import Backend, RigidBodyBackend
from cdpr.plugins.snapshots import put_back, save
from cdpr_backends.ideal import require_ideal

# Otherwise MuJoCo prints what it finds bad in a state and appends it to MUJOCO_LOG.TXT in the user's folder. The guards
# of the loop find the same in the same step. (MuJoCo knows only one such setting for the whole process.)
mujoco.set_mju_user_warning(lambda text: None)

ROUNDING = 1e-12  # keeps a sum of moments from missing the triangle inequality by its last bit

INTEGRATORS = {"euler": mujoco.mjtIntegrator.mjINT_EULER, "rk4": mujoco.mjtIntegrator.mjINT_RK4}

INTEGRATION = mujoco.mjtState.mjSTATE_INTEGRATION

PLATFORM = 1  # its number among the bodies; 0 is the world


def make(robot: Robot, gravity: Array, physics_step: float, options: Any) -> Backend:
    """Return the backend for the chosen kind of cables."""
    if options.cables == "ups":
        from cdpr_backends.mujoco_ups import MujocoUps

        return MujocoUps(robot, gravity, physics_step, options)
    if options.cables == "native":
        require_ideal(robot, options.cables)
        return MujocoTendons(robot, gravity, physics_step, options)
    return MujocoBackend(robot, gravity, physics_step, options)


class MujocoBackend(RigidBodyBackend):
    """A body under the wrench of cdpr's cable kernel."""

    def build(self) -> None:
        """Make the world."""
        self._world = world = World(self.frame, describe(self.frame, self.gravity, self.physics_step, "euler"))
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


class MujocoTendons(Backend):
    """The same body held by spatial tendons: MuJoCo evaluates the cables, at every stage of its integrator."""

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.frame = frame = BodyFrame(robot)
        spec = describe(frame, self.gravity, physics_step, options.integrator)
        add_tendons(spec, frame.anchors)
        self._world = World(frame, spec)
        self._body = np.zeros(13)
        self._slack = np.zeros(robot.m)  # the tendons already pull
        self._applied = np.zeros(6)
        self._read = self._world.reader(self._body)
        self._apply = self._world.applier(self._applied)
        self._bad_command = self._world.data.warning[mujoco.mjtWarning.mjWARN_BADCTRL]

    def reset(self, state: Array) -> None:
        """Put the platform into `state` (13,)."""
        from_platform(self.frame.offset, np.array(state, dtype=np.float64), self._body)
        self._world.write(self._body)
        self._publish()

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        world = self._world
        world.data.ctrl[:] = self.command
        if self.external.any() or self._applied.any():
            for _ in range(n):  # the external wrench moves with the platform
                self._read()
                applied_wrench(
                    self.frame.anchors, self.frame.offset, self._slack, self.external, self._body, self._applied
                )
                self._apply()
                mujoco.mj_step(world.model, world.data)
        else:
            mujoco.mj_step(world.model, world.data, n)
        self._publish()
        if self._bad_command.number:  # MuJoCo has put zeros in place of the commands
            self._bad_command.number = 0
            self.state[:] = np.nan

    def engine_time(self) -> float:
        """Return MuJoCo's time, s."""
        return float(self._world.data.time)

    def snapshot(self) -> object:
        """Return MuJoCo's state and our arrays."""
        return self._world.save(), save(self._arrays)

    def restore(self, snapshot: Any) -> None:
        """Go back to a snapshot."""
        engine, arrays = snapshot
        self._world.put_back(engine)
        put_back(arrays, self._arrays)

    @property
    def _arrays(self) -> tuple[Array, ...]:
        return self.command, self.external, self._applied, self._body, self.state

    def _publish(self) -> None:
        self._read()
        to_platform(self.frame.offset, self._body, self.state)


class World:
    """MuJoCo's model and data of one platform."""

    def __init__(self, frame: BodyFrame, spec: mujoco.MjSpec) -> None:
        self.frame = frame
        # The compiler refuses principal moments that miss the triangle inequality by mere rounding: they are put in
        # afterwards.
        moments = frame.moments
        spec.body("platform").inertia = np.minimum(moments, (moments.sum() - moments) * (1.0 - ROUNDING))
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.model.body_inertia[PLATFORM] = frame.moments
        mujoco.mj_setConst(self.model, self.data)
        self._home = np.zeros(3)  # where the slides measure from, or the ball is

    def write(self, body: Array) -> None:
        """Reset all and put the body into a body state (13,)."""
        guide, data = self.frame.guide, self.data
        if guide is None:
            mujoco.mj_resetData(self.model, data)
            write_free_joint(body, data.qpos, data.qvel)
        else:
            self._home[:] = body[:3] * (1.0 - guide.packed[:3])
            self.model.body_pos[PLATFORM] = self._home
            mujoco.mj_resetData(self.model, data)
            if guide.spherical:
                write_ball(body, data.qpos, data.qvel)
            else:
                data.qpos[:], data.qvel[:] = guide.coordinates(body, self._home)

    def reader(self, body: Array) -> Callable[[], None]:
        """Return the function that reads the body state into `body` (13,)."""
        guide, data = self.frame.guide, self.data
        if guide is None:
            return partial(read_free_joint, data.qpos, data.qvel, body)
        if guide.spherical:
            return partial(read_ball, self._home, data.qpos, data.qvel, body)
        return partial(from_coordinates, guide.packed, guide.rows, self._home, data.qpos, data.qvel, body)

    def save(self) -> tuple[Array, Array]:
        """Return where the slides measure from, and all that MuJoCo's next step depends on."""
        engine = np.zeros(mujoco.mj_stateSize(self.model, INTEGRATION))
        mujoco.mj_getState(self.model, self.data, engine, INTEGRATION)
        return self._home.copy(), engine

    def put_back(self, saved: tuple[Array, Array]) -> None:
        """Undo what happened since `save`."""
        self._home[:] = saved[0]
        if self.frame.guide is not None:
            self.model.body_pos[PLATFORM] = self._home
        mujoco.mj_setState(self.model, self.data, saved[1], INTEGRATION)

    def applier(self, applied: Array) -> Callable[[], None]:
        """Return the function that applies `applied` (6,), about the body frame's origin, until it is called again."""
        guide, data = self.frame.guide, self.data
        if guide is None:
            return partial(np.copyto, data.xfrc_applied[PLATFORM], applied)
        if guide.spherical:  # a moment alone acts alike wherever it is applied
            return partial(np.copyto, data.xfrc_applied[PLATFORM, 3:], applied[3:])
        return partial(onto_coordinates, guide.rows, applied, data.qfrc_applied)


def describe(frame: BodyFrame, gravity: Array, step: float, integrator: str) -> mujoco.MjSpec:
    """Describe a world with one body, free or on the slides and the hinge or the ball of its guide."""
    spec = mujoco.MjSpec()
    spec.option.timestep = step
    spec.option.gravity = gravity
    spec.option.integrator = INTEGRATORS[integrator]
    # By default MuJoCo answers a bad acceleration by silently resetting itself; without that, NaN stays visible.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_AUTORESET
    body = spec.worldbody.add_body(name="platform", mass=frame.mass, explicitinertial=True)
    body.ipos, body.iquat = frame.center, frame.axes
    if frame.guide is None:
        body.add_freejoint()
    elif frame.guide.spherical:
        body.add_joint(type=mujoco.mjtJoint.mjJNT_BALL)
    else:
        for axis in frame.guide.slides:
            body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=np.eye(3)[axis])
        if frame.guide.hinge is not None:
            body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=np.eye(3)[frame.guide.hinge])
    return spec


def add_tendons(spec: mujoco.MjSpec, anchors: Array) -> None:
    """Add one tendon and one force actuator per cable; a positive tendon force pushes, hence the gear of -1."""
    for i, row in enumerate(anchors):
        spec.worldbody.add_site(name=f"frame_{i}", pos=row[:3])
        spec.body("platform").add_site(name=f"platform_{i}", pos=row[3:])
        tendon = spec.add_tendon(name=f"cable_{i}")
        tendon.wrap_site(f"frame_{i}")
        tendon.wrap_site(f"platform_{i}")
        actuator = spec.add_actuator(name=f"cable_{i}", target=f"cable_{i}", trntype=mujoco.mjtTrn.mjTRN_TENDON)
        actuator.gear[0] = -1.0


@kernel
def read_free_joint(qpos: Array, qvel: Array, body: Array) -> None:
    """Read MuJoCo's free joint, whose angular velocity is in body axes, into a body state (13,)."""
    for i in range(7):
        body[i] = qpos[i]
    for i in range(3):
        body[7 + i] = qvel[i]
    store(rotate(quaternion(qpos, 3), vector(qvel, 3)), body, 10)


@kernel
def write_free_joint(body: Array, qpos: Array, qvel: Array) -> None:
    """Undo `read_free_joint`."""
    for i in range(7):
        qpos[i] = body[i]
    for i in range(3):
        qvel[i] = body[7 + i]
    store(rotate(conjugate(quaternion(body, 3)), vector(body, 10)), qvel, 3)


@kernel
def read_ball(home: Array, qpos: Array, qvel: Array, body: Array) -> None:
    """Read MuJoCo's ball joint at `home` (3,), whose angular velocity is in body axes, into a body state (13,)."""
    for i in range(4):
        body[3 + i] = qpos[i]
    for i in range(3):
        body[i] = home[i]
        body[7 + i] = 0.0
    store(rotate(quaternion(qpos, 0), vector(qvel, 0)), body, 10)


@kernel
def write_ball(body: Array, qpos: Array, qvel: Array) -> None:
    """Undo `read_ball`."""
    for i in range(4):
        qpos[i] = body[3 + i]
    store(rotate(conjugate(quaternion(body, 3)), vector(body, 10)), qvel, 0)
