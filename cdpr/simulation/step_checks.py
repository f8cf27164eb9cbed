"""Checks of the physics step for the winches and cables of a robot at a pose."""

from __future__ import annotations

from dataclasses import dataclass, replace

from cdpr.base.errors import CdprError
from cdpr.cables import chain_of
from cdpr.cables.drums import emptied
from cdpr.mechanics.kinematics import lengths
from cdpr.model import Robot
from cdpr.model.robot import Array

FIXED = 1e9  # factor of the inertia of a platform that does not move


class StepTooLongError(CdprError):
    """Reason why a physics step is too long for cables and winches."""


@dataclass(frozen=True, eq=False)
class Circumstances:
    """Robot and pose of a check.

    Attributes:
        robot: the robot, with cables that are not ideal.
        state: (13,), as in `cdpr.model`; only its pose is used.
        gravity: (3,) m/s^2, world.
        plant: what would diverge, for messages.
        key: name of the step, for messages.
    """

    robot: Robot
    state: Array
    gravity: Array
    plant: str
    key: str = "simulation.physics_step"

    def with_fixed_platform(self) -> Circumstances:
        """Return the same with a platform that cables practically do not move, and the same weight."""
        body = self.robot.platform
        body = replace(body, mass=FIXED * body.mass, inertia=FIXED * body.inertia)
        return replace(self, robot=replace(self.robot, platform=body), gravity=self.gravity / FIXED)


def check_step(about: Circumstances, step: float, *, fourth_order: bool) -> None:
    """Reject a physics step at which cables and winches are unstable. Empty drums are not checked.

    Args:
        about: robot and pose.
        step: s.
        fourth_order: True for the scheme of Runge and Kutta, False for the semi-implicit one of engines.

    Raises:
        CdprError: if the step is too long for the lag of a torque.
        StepTooLongError: if it is too long for the stiffness of cables and loops.
    """
    from cdpr.mechanics.limiting_part import limiting_part
    from cdpr.mechanics.stability import (
        longest,
        oscillator,
        shortest_creep,
        shortest_lag,
        stable,
        supports_oscillator,
    )

    robot, key, plant = about.robot, about.key, about.plant
    lag, name = shortest_lag(robot)
    if step > 2.0 * lag:
        raise CdprError(
            f"{key} {step:g} s is too long for the winch of cable '{name}' with the torque_lag {lag:g} s: expected at "
            "most twice the lag; set torque_lag: 0, or a shorter step"
        )
    if step > (time := shortest_creep(robot)):
        raise CdprError(
            f"{key} {step:g} s is too long for cables whose tension relaxes in {time:g} s: expected at most this "
            "time; set longer times in cable.creep, or a shorter step"
        )
    if not supports_oscillator(robot) or empty_drum(robot, about.state):
        return
    found = oscillator(robot, about.state, about.gravity)
    scheme = found.runge_kutta if fourth_order else found.semi_implicit
    if stable(scheme(step)):
        return
    limit, part = longest(scheme, step), limiting_part(robot, found.M, found.parts, step)
    culprit = part and f"; {part}"
    if not limit:
        raise StepTooLongError(
            f"no {key} above 1e-9 s is stable for these cables and winches, on {plant}: expected larger values of "
            "inertia, drum_radius and coulomb_speed of the winches and friction_speed of the pulleys, or lower "
            f"stiffness, damping, friction and gains{culprit}"
        )
    swinging = (
        f"they swing with up to {found.fastest:.4g} rad/s (step * omega = {step * found.fastest:.3g}), and damping, "
        "friction and gains require short steps, too"
    )
    raise StepTooLongError(
        f"{key} {step:g} s is too long for these cables and winches, and {plant} would diverge: at the initial pose "
        f"{swinging if found.fastest > 0.0 else 'damping and friction require short steps'}; it is stable up to "
        f"{limit:g} s{culprit}"
    )


def empty_drum(robot: Robot, state: Array) -> str:
    """Return a message on the first drum that is empty at the pose of a state (13,); "" if none is."""
    if not any(chain_of(robot, cable).winch.states for cable in robot.cables):
        return ""  # no drum acts on a cable
    return emptied(robot, lengths(robot, state))
