"""Reuse of a loop for a scenario that differs in numbers only."""

from __future__ import annotations

from dataclasses import fields, replace

from pydantic import BaseModel

from cdpr.model import Robot
from cdpr.plugins import Backend, Controller
from cdpr.plugins.compiled import speaks_for
from cdpr.scenario import Scenario
from cdpr.simulation.loop import Loop

# Sections that may differ, `robot` in its platform only.
FREE = {"initial", "trajectory", "robot"}
# Methods of plugins that may depend on the platform.
WORK = "__init__", "control", "compiled", "reset", "step", "operations"


def renew(loop: Loop, before: Scenario, now: Scenario) -> bool:
    """Turn a loop built from one scenario into the loop of another, to begin anew; return False if it must be built.

    The scenarios may differ in the initial state, the motion, options that may change during a run, and the platform.

    Raises:
        CdprError: if a plugin rejects its options.
    """
    parts, settings = loop.parts, loop.parts.settings
    if settings is None or loop.memory is None or parts.more or not _alike(before, now):
        return False
    if now.robot is not before.robot and not _renew_platform(loop, now):
        return False
    settings.renew(now.options().values)
    loop.parts = replace(
        parts,
        robot=now.robot,
        controlled_robot=now.controlled_robot,
        planned=now.planned,
        trajectory=now.desired,
    )
    return now.desired is parts.trajectory or loop.follow(now.desired)


def _alike(before: Scenario, now: Scenario) -> bool:
    sections = type(now.sections).model_fields.keys() - FREE
    changeable = set(now.options().changeable())
    return (
        not now.events
        and now.actuators is None
        and now.nominal is None
        and all(getattr(before.sections, name) == getattr(now.sections, name) for name in sections)
        and all(
            getattr(before.robot, each.name) is getattr(now.robot, each.name)
            for each in fields(Robot)
            if each.name != "platform"
        )
        and before.backend_options() == now.backend_options()
        and _differing("controller", before.controller_options, now.controller_options) <= changeable
        and _differing("solver", before.solver_options, now.solver_options) <= changeable
    )


def _differing(role: str, before: BaseModel, now: BaseModel) -> set[str]:
    return {f"{role}.{name}" for name, value in now if getattr(before, name) != value}


def _speaks(plugin: Backend | Controller) -> bool:
    """Return True if `renew` of a plugin is valid for its other methods."""
    does = [getattr(plugin, name) for name in WORK if hasattr(plugin, name)]
    return hasattr(plugin, "renew") and all(speaks_for(plugin.renew, each) for each in does)


def _renew_platform(loop: Loop, now: Scenario) -> bool:
    """Give all parts the robot, whose platform is another one; return False if one cannot take it."""
    parts, robot = loop.parts, now.robot
    solver = now.plugins.get("solver", now.solver.type)
    if not solver.properties(now.solver_options).get("platform_independent"):  # type: ignore[arg-type]
        return False
    for plugin in (parts.backend, parts.controller):
        if not _speaks(plugin) or not plugin.renew(robot):
            return False
    loop.present.renew(robot)
    return True
