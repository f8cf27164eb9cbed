"""Warning about a start at rest (`initial.equilibrium`) far from the initial pose of the scenario."""

from __future__ import annotations

import math
from contextlib import ExitStack

import numpy as np

from cdpr.base.defaults import BACKEND
from cdpr.base.problems import Path
from cdpr.log.event import Event
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.scenario import Scenario
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop
from cdpr.simulation.resting_start import KEY, warm_up

PATH: Path = ("initial", "equilibrium")

# Stretch and sag at working loads move a platform by a few percent of the frame: 3 % in `camera_robot`, whose lines are
# very soft (EA 2 kN). A larger distance or turn usually belongs to another equilibrium, such as an overturned platform.
FAR = 0.05  # of the largest extent of the frame's anchors
TURNED = 0.3  # rad


def far_start(scenario: Scenario, state: Array) -> str:
    """Return the warning that a run starts at rest far from the initial pose; "" if it is near or does not start so.

    Args:
        scenario: scenario.
        state: (13,) or (7,), pose of the first sample.
    """
    if not scenario.initial.equilibrium:
        return ""
    given, extent = scenario.initial.state(), float(np.ptp(scenario.robot.anchors[:, :3], axis=0).max())
    distance = float(np.linalg.norm(state[:3] - given[:3]))
    turned = rotations.multiply(rotations.conjugate(given[3:7]), state[3:7])
    turn = float(np.linalg.norm(rotations.rotation_vector(turned)))
    if distance <= FAR * extent and turn <= TURNED:
        return ""
    position, attitude = (
        ", ".join(f"{round(value, 6) + 0.0:.4g}" for value in part) for part in (state[:3], state[3:7])
    )
    return (
        f"the pose of rest for the first commands is {distance:.3g} m and {math.degrees(turn):.3g} deg from the "
        f"initial pose, more than {FAR * extent:.3g} m ({FAR:.0%} of the frame) or {math.degrees(TURNED):.3g} deg: the "
        "motion starts with this error, and the platform may be in another equilibrium than intended; choose an "
        f"initial pose near the pose of rest (position [{position}], quaternion [{attitude}]), or hold this pose by "
        "other controller options, such as flex_compensation or more pretension"
    )


def far_start_events(scenario: Scenario, state: Array) -> list[Event]:
    """Return the event of a start far from the initial pose; arguments as for `far_start`."""
    text = far_start(scenario, state)
    return [Event(0.0, "start", f"{KEY}: {text}")] if text else []


def start_problems(scenario: Scenario) -> list[tuple[Path, str]]:
    """Return the same warning, with its key, before a run.

    Raises:
        CdprError: if there is no stable pose of rest.
    """
    if not scenario.initial.equilibrium:
        return []
    contact = {"world.contact": False} if scenario.world.contact else {}
    held = scenario.with_changes({"simulation.backend": BACKEND, **contact})
    with ExitStack() as opened:
        parts = build(held)
        opened.callback(parts.controller.close)
        opened.callback(parts.backend.close)
        loop = Loop(parts)
        opened.callback(loop.close)
        warm_up(loop, held)
        text = far_start(scenario, parts.backend.state)
    return [(PATH, text)] if text else []
