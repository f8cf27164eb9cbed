"""Start of a run at rest: the pose at which the cables hold the platform with the first commands of their winches."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.cables import TENSION, commands_of
from cdpr.log.blocks import BLOCK
from cdpr.mechanics.kinematics import make_state
from cdpr.model.robot import Array
from cdpr.plugins.registry import Registered
from cdpr.scenario import Scenario
from cdpr.simulation.loop_parts import loop_parts
from cdpr.simulation.moving_anchors import moving_part

if TYPE_CHECKING:
    from cdpr.simulation.loop import Loop

KEY = "initial.equilibrium"


def check_resting_start(scenario: Scenario, controller: Registered) -> None:
    """Reject a start at rest that is not defined.

    Raises:
        CdprError: with a controller with feedback, a velocity, actuators, or anchors that move.
    """
    initial = scenario.initial
    if not initial.equilibrium:
        return
    if has_feedback(controller):
        plugins = scenario.plugins
        usable = [name for name in plugins.names("controller") if not has_feedback(plugins.get("controller", name))]
        raise CdprError(
            f"{KEY}: the first commands of controller '{controller.info.name}' depend on the pose of the platform: "
            f"choose a controller without feedback ({', '.join(usable)}), or remove the key"
        )
    if np.any(scenario.initial.state()[7:]):
        raise CdprError(f"{KEY}: a platform at rest has no velocity: remove the initial velocities, or the key")
    if scenario.actuators is not None:
        raise CdprError(f"{KEY}: the lengths of cables on actuators are not known: remove the actuators, or the key")
    if (part := moving_part(loop_parts(scenario))) is not None:
        raise CdprError(f"{KEY}: does not support anchors that move, by {part.title}: remove the key")


def has_feedback(controller: Registered) -> bool:
    """Return False if a controller declares that its commands do not depend on the state."""
    return bool(controller.info.properties.get("feedback", True))


def warm_up(loop: Loop, scenario: Scenario) -> None:
    """Warm up a loop, and reset it to the start of a scenario.

    Raises:
        CdprError: as `Loop.warm_up`, or if no stable pose of rest is found.
    """
    start = scenario.initial.state()
    loop.warm_up(start)
    if scenario.initial.equilibrium:
        with loop.timed():
            loop.begin(np.zeros((BLOCK, len(loop.row))), BLOCK)
            loop.decide()
        loop.reset(_at_rest(loop, start))


def _at_rest(loop: Loop, start: Array) -> Array:
    """Return the state (13,) at rest for the commands of a loop at its first sample, near the state `start` (13,)."""
    from cdpr.mechanics.equilibrium import find_equilibrium  # only such runs need it

    robot, gravity = loop.parts.backend.robot, loop.parts.backend.gravity
    takes_tension = np.array([each == TENSION for each in commands_of(robot)])
    unwound = np.full(robot.m, np.nan)
    if not takes_tension.all():
        unwound = np.where(takes_tension, np.nan, loop.present.view("unstretched_length"))
    found = find_equilibrium(robot, unwound, np.where(takes_tension, loop.winding.drive, np.nan), start[:7], gravity)
    if not found.converged:
        raise CdprError(f"{KEY}: no pose of rest was found for the first commands of the winches: {found.problem}")
    if found.stability == "unstable":
        raise CdprError(
            f"{KEY}: the pose of rest for the first commands of the winches is unstable: choose another initial pose, "
            "or controller options that keep the cables taut"
        )
    return make_state(found.pose[:3], found.pose[3:])
