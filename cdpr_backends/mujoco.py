"""MuJoCo: one free body under our cable wrench, or with MuJoCo's own spatial tendons as cables."""

from __future__ import annotations

from functools import partial
from typing import Any

import mujoco
import numpy as np

from cdpr.model import Robot
from cdpr.model.body_frame import BodyFrame, applied_wrench, from_platform, to_platform
from cdpr.model.jit import kernel
from cdpr.model.kernels import conjugate, quaternion, rotate, store, vector
from cdpr.model.robot import Array
from cdpr.plugins import Backend, RigidBodyBackend

# Otherwise MuJoCo prints what it finds bad in a state and appends it to MUJOCO_LOG.TXT in the user's folder. The guards
# of the loop find the same in the same step. (MuJoCo knows only one such setting for the whole process.)
mujoco.set_mju_user_warning(lambda text: None)

ROUNDING = 1e-12  # keeps a sum of moments from missing the triangle inequality by its last bit

INTEGRATORS = {"euler": mujoco.mjtIntegrator.mjINT_EULER, "rk4": mujoco.mjtIntegrator.mjINT_RK4}


def make(robot: Robot, gravity: Array, physics_step: float, options: Any) -> Backend:
    """Return the backend for the chosen kind of cables."""
    kind = MujocoTendons if options.cables == "native" else MujocoBackend
    return kind(robot, gravity, physics_step, options)


class MujocoBackend(RigidBodyBackend):
    """A free body under the wrench of cdpr's cable kernel."""

    def build(self) -> None:
        """Make the world; the wrench goes straight into MuJoCo's own array, which keeps it until rewritten."""
        model, data = compiled(free_body(self.frame, self.gravity, self.physics_step, "euler"), self.frame)
        self._data = data
        self.applied = data.xfrc_applied[1]
        self._read = partial(read_free_joint, data.qpos, data.qvel, self.body)
        self._advance = partial(mujoco.mj_step, model, data)
        self._model = model

    def write(self) -> None:
        """Put the body into `body`."""
        mujoco.mj_resetData(self._model, self._data)
        write_free_joint(self.body, self._data.qpos, self._data.qvel)

    def read(self) -> None:
        """Read the body into `body`."""
        self._read()

    def advance(self) -> None:
        """Advance by one physics step."""
        self._advance()

    def engine_time(self) -> float:
        """Return MuJoCo's time, s."""
        return float(self._data.time)


class MujocoTendons(Backend):
    """The same body held by spatial tendons: MuJoCo evaluates the cables, at every stage of its integrator."""

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.frame = frame = BodyFrame(robot)
        spec = free_body(frame, self.gravity, physics_step, options.integrator)
        add_tendons(spec, frame.anchors)
        self._model, self._data = compiled(spec, frame)
        data = self._data
        self._body = np.zeros(13)
        self._slack = np.zeros(robot.m)  # the tendons already pull
        self._read = partial(read_free_joint, data.qpos, data.qvel, self._body)

    def reset(self, state: Array) -> None:
        """Put the platform into `state` (13,)."""
        mujoco.mj_resetData(self._model, self._data)
        from_platform(self.frame.offset, np.array(state, dtype=np.float64), self._body)
        write_free_joint(self._body, self._data.qpos, self._data.qvel)
        self._publish()

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        data = self._data
        data.ctrl[:] = self.command
        if self.external.any() or data.xfrc_applied.any():
            self._step_with_external(n)
        else:
            mujoco.mj_step(self._model, data, n)
        self._publish()

    def engine_time(self) -> float:
        """Return MuJoCo's time, s."""
        return float(self._data.time)

    def _step_with_external(self, n: int) -> None:
        """Move the external wrench from the platform's origin to the centre of mass before each step."""
        applied = self._data.xfrc_applied[1]
        for _ in range(n):
            self._read()
            applied_wrench(self.frame.anchors, self.frame.offset, self._slack, self.external, self._body, applied)
            mujoco.mj_step(self._model, self._data)

    def _publish(self) -> None:
        self._read()
        to_platform(self.frame.offset, self._body, self.state)


def free_body(frame: BodyFrame, gravity: Array, step: float, integrator: str) -> mujoco.MjSpec:
    """Describe a world with one free body (number 1), its frame at the centre of mass along the principal axes."""
    spec = mujoco.MjSpec()
    spec.option.timestep = step
    spec.option.gravity = gravity
    spec.option.integrator = INTEGRATORS[integrator]
    # By default MuJoCo answers a bad acceleration by silently resetting itself; without that, NaN stays visible.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_AUTORESET
    body = spec.worldbody.add_body(name="platform", mass=frame.mass, explicitinertial=True)
    body.add_freejoint()
    return spec


def compiled(spec: mujoco.MjSpec, frame: BodyFrame) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Compile a world around the platform.

    MuJoCo's compiler refuses principal moments that miss the triangle inequality by mere rounding, so they are put in
    afterwards.
    """
    moments = frame.moments
    spec.body("platform").inertia = np.minimum(moments, (moments.sum() - moments) * (1.0 - ROUNDING))
    model = spec.compile()
    data = mujoco.MjData(model)
    model.body_inertia[1] = moments
    mujoco.mj_setConst(model, data)
    return model, data


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
