"""MuJoCo model and data of one platform."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NoReturn

import mujoco
import numpy as np

from cdpr.mechanics.body_frame import BodyFrame
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.native.rotations import rotate
from cdpr.plugins import Backend
from cdpr.plugins.inertia import Inertia, turned
from cdpr_backends import MUJOCO_RANGE
from cdpr_backends.mujoco.direct import Direct, direct

# By default, MuJoCo prints warnings about bad states and appends them to MUJOCO_LOG.TXT in the user's folder. The
# checks of the simulation detect the same errors in the same step. (The setting applies to the whole process.)
mujoco.set_mju_user_warning(lambda text: None)

ROUNDING = 1e-12  # prevents a violation of the triangle inequality of moments by round-off

# Any centre of mass [m] and axes off the joints.
SOMEWHERE, TURNED = (1.0, 1.0, 1.0), (0.5, 0.5, 0.5, 0.5)

INTEGRATORS = {"euler": mujoco.mjtIntegrator.mjINT_EULER, "rk4": mujoco.mjtIntegrator.mjINT_RK4}

INTEGRATION = mujoco.mjtState.mjSTATE_INTEGRATION

PLATFORM = 1  # index among the bodies; 0 is the world

TITLE = "MuJoCo"
SMALLEST, SLIMMEST = MUJOCO_RANGE["smallest"], MUJOCO_RANGE["slimmest"]


class World:
    """Model and data, and the conversion of body states."""

    def __init__(self, frame: BodyFrame, spec: mujoco.MjSpec) -> None:
        self.frame = frame
        # The compiler rejects principal moments that violate the triangle inequality by round-off alone, so the exact
        # values are set afterwards.
        moments = frame.moments
        spec.body("platform").inertia = np.minimum(moments, (moments.sum() - moments) * (1.0 - ROUNDING))
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self._put_mass(self.data)
        self._home = np.zeros(3)  # origin of the slides, or position of the spherical joint

    def write(self, body: Array) -> None:
        """Reset the data and set the body to a body state (13,)."""
        guide, data = self.frame.guide, self.data
        if guide is None:
            mujoco.mj_resetData(self.model, data)
            self._put_free(body)
        else:
            self._home[:] = body[:3] * (1.0 - guide.packed[:3])
            self.model.body_pos[PLATFORM] = self._home
            mujoco.mj_resetData(self.model, data)
            if guide.spherical:
                data.qpos[:4], data.qvel[:3] = body[3:7], along_body(body)
            else:
                data.qpos[:], data.qvel[:] = guide.coordinates(body, self._home)

    @property
    def diagonal(self) -> bool:
        """Return True if MuJoCo chose a diagonal mass matrix, for a centre of mass at the joints of a guide."""
        return self.frame.guide is not None and bool(self.model.body_simple[PLATFORM])

    def continue_from(self, other: World) -> None:
        """Take the complete state of another world of the same joints."""
        self.put_back(other.save())

    def load(self, body: Array) -> None:
        """Take mass properties of the frame and, for a free platform, a body state (13,); the clock stays."""
        self._put_mass(mujoco.MjData(self.model))  # not `data`, whose state it resets
        if self.frame.guide is None:
            self._put_free(body)

    def _put_mass(self, scratch: mujoco.MjData) -> None:
        """Set the mass properties of the frame and all constants that depend on them."""
        frame, model = self.frame, self.model
        model.body_mass[PLATFORM], model.body_inertia[PLATFORM] = frame.mass, frame.moments
        model.body_ipos[PLATFORM], model.body_iquat[PLATFORM] = frame.center, frame.axes
        mujoco.mj_setConst(model, scratch)

    def _put_free(self, body: Array) -> None:
        # Joints of legs follow these.
        self.data.qpos[:7], self.data.qvel[:6] = body[:7], [*body[7:10], *along_body(body)]

    def reader(self, body: Array) -> Callable[[], object]:
        """Return the operation that reads the body state into `body` (13,)."""
        guide, data = self.frame.guide, self.data
        if guide is None:
            return bind("mujoco_free_state", coordinates=data.qpos[:7], rates=data.qvel[:6], body=body)
        if guide.spherical:
            return bind("mujoco_ball_state", home=self._home, coordinates=data.qpos[:4], rates=data.qvel[:3], body=body)
        joints = {"coordinate": data.qpos, "rate": data.qvel}
        return bind("guide_state", guide=guide.packed, rows=guide.rows, home=self._home, **joints, body=body)

    def held(self) -> Inertia:
        """Return the inertia of the body in MuJoCo."""
        model = self.model
        inertia = turned(model.body_inertia[PLATFORM], model.body_iquat[PLATFORM])
        return Inertia(float(model.body_mass[PLATFORM]), inertia, model.body_ipos[PLATFORM].copy())

    @cached_property
    def direct(self) -> Direct | None:
        """Direct access of compiled code to the step, None if only the binding can perform it."""
        return direct(self.model, self.data)

    def save(self) -> tuple[Array, Array]:
        """Return the origin of the slides, and the complete state on which MuJoCo's next step depends."""
        engine = np.zeros(mujoco.mj_stateSize(self.model, INTEGRATION))
        mujoco.mj_getState(self.model, self.data, engine, INTEGRATION)
        return self._home.copy(), engine

    def put_back(self, saved: tuple[Array, Array]) -> None:
        """Restore a state of `save`."""
        self._home[:] = saved[0]
        if self.frame.guide is not None:
            self.model.body_pos[PLATFORM] = self._home
        mujoco.mj_setState(self.model, self.data, saved[1], INTEGRATION)

    def applier(self, applied: Array) -> Callable[[], object]:
        """Return the operation that applies `applied` (6,) about the body frame's origin until the next call of it."""
        guide, data = self.frame.guide, self.data
        if guide is None:
            return bind("copy", source=applied, target=data.xfrc_applied[PLATFORM])
        if guide.spherical:  # the effect of a moment does not depend on its point of application
            return bind("copy", source=applied[3:], target=data.xfrc_applied[PLATFORM, 3:])
        return bind("guide_forces", rows=guide.rows, applied=applied, forces=data.qfrc_applied)


def along_body(body: Array) -> Array:
    """Return the angular velocity (3,) of a body state (13,) along the body's axes [rad/s]."""
    return rotate(rotations.conjugate(body[3:7]), body[10:])


class InWorld(Backend):
    """Plant in a world that is never rebuilt."""

    _world: World

    @property
    def _direct(self) -> Direct | None:
        return self._world.direct

    def engine_time(self) -> float:
        """Return the time of MuJoCo [s]."""
        return float(self._world.data.time)

    def clock_act(self, clock: Array) -> Callable[[], object]:
        """Return the operation that reads the time of MuJoCo into `clock` (1,)."""
        direct = self._direct
        return super().clock_act(clock) if direct is None else direct.clock(clock)

    def refuse(self, code: int) -> NoReturn:
        """Raise the error of a failed step that the binding would have raised."""
        direct = self._direct
        raise mujoco.FatalError(f"error {code}" if direct is None else direct.refusal())


def specify(frame: BodyFrame, gravity: Array, step: float, integrator: str, *, general: bool = False) -> mujoco.MjSpec:
    """Return the description of a world with one body, free or on the joints of its guide.

    A `general` one has a full mass matrix, for any centre of mass and axes; `World` sets those of the frame.
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = step
    spec.option.gravity = gravity
    spec.option.integrator = INTEGRATORS[integrator]
    # By default, MuJoCo resets itself without a message after a bad acceleration; without this reset, NaN remains
    # visible.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_AUTORESET
    body = spec.worldbody.add_body(name="platform", mass=frame.mass, explicitinertial=True)
    body.ipos, body.iquat = (SOMEWHERE, TURNED) if general else (frame.center, frame.axes)
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
