"""Reference backend: classical Runge-Kutta scheme that evaluates the cables at every stage."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.cables import chain_of, immediate, rubs
from cdpr.mechanics.body_frame import BodyFrame
from cdpr.mechanics.guide import Guide
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import Backend
from cdpr_backends.scheme import Integrator, keep_state


def make(robot: Robot, gravity: Array, physics_step: float, options: Any) -> Backend:
    """Return the integrator of the chosen scheme, for a free or a guided platform or for cables on winches."""
    if options is not None and options.scheme == "semi_implicit_euler":
        from cdpr_backends.reference_euler import SemiImplicitEuler

        return SemiImplicitEuler(robot, gravity, physics_step, options)
    if robot.n == 6 and rubs(robot) and all(chain_of(robot, cable).immediate for cable in robot.cables):
        from cdpr_backends.reference_friction import FrictionReference

        return FrictionReference(robot, gravity, physics_step, options)
    if not immediate(robot):
        from cdpr_backends.reference_winches import WinchReference

        return WinchReference(robot, gravity, physics_step, options)
    if robot.n == 6:
        return ReferenceBackend(robot, gravity, physics_step, options)
    if Guide(robot).spherical:
        from cdpr_backends.reference_spherical import SphericalReference

        return SphericalReference(robot, gravity, physics_step, options)
    from cdpr_backends.reference_guided import GuidedReference

    return GuidedReference(robot, gravity, physics_step, options)


class ReferenceBackend(Integrator):
    """Integrator of position, attitude, momentum and angular momentum by the classical scheme of fourth order.

    The variables are those of the centre of mass. The angular momentum is in world axes, where it is constant without a
    torque, so that it is conserved to round-off.
    """

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.frame = frame = BodyFrame(robot)
        self._body = np.zeros(13)
        self._inertial = np.array([frame.mass, *frame.moments])
        self._momentum = np.zeros(3)  # angular, about the centre of mass, in world axes
        moving = {"body": self._body, "momentum": self._momentum}
        self._begin = bind("reference_begin", offset=frame.offset, moments=frame.moments, state=self.state, **moving)
        self.bind_steps(
            "reference_step",
            lines=frame.line_table,
            offset=frame.offset,
            inertial=self._inertial,
            gravity=self.gravity,
            command=self.command,
            external=self.external,
            **moving,
        )
        self.arrays = (self.command, self.external, self._body, self._momentum, self.state)

    def renew(self, robot: Robot) -> bool:
        """Move another platform from the next reset on."""
        before, self.robot = self.robot, robot
        self.frame.mass = self._inertial[0] = robot.platform.mass
        if robot.inertial[1:].tobytes() != before.inertial[1:].tobytes():
            frame = BodyFrame(robot)
            self._inertial[1:] = frame.moments
            for name in ("line_table", "offset", "moments"):
                getattr(self.frame, name)[:] = getattr(frame, name)
        return True

    def load(self, robot: Robot) -> None:
        """Move another platform from now on, with the same pose and twist of its origin."""
        self.renew(robot)
        keep_state(self.state, self._begin)

    def reset(self, state: Array) -> None:
        """Set the platform to `state` (13,)."""
        self.state[:] = state
        self._begin()
        self.restart()
