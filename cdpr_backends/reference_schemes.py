"""Choice of the integrator of the backend `reference`."""

from __future__ import annotations

from typing import Any

from cdpr.cables import chain_of, immediate, rubs
from cdpr.mechanics.guide import Guide
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Backend


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
        from cdpr_backends.reference import ReferenceBackend

        return ReferenceBackend(robot, gravity, physics_step, options)
    if Guide(robot).spherical:
        from cdpr_backends.reference_spherical import SphericalReference

        return SphericalReference(robot, gravity, physics_step, options)
    from cdpr_backends.reference_guided import GuidedReference

    return GuidedReference(robot, gravity, physics_step, options)
