"""Geometric checks of poses that cables cannot support."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cdpr.base import tolerances
from cdpr.model import DOF_NAMES, Robot, rotations
from cdpr.model.robot import Array
from cdpr.scenario.events import first_sample
from cdpr.scenario.plausible.setup import Finding, Setup
from cdpr.scenario.static_feasibility import unheld

# If the anchors' heights differ by less than this fraction of their extent, the platform is suspended and may be
# lowered by any distance; otherwise nothing holds it down below the lowest anchor.
LEVEL = 0.1
# In frame sizes from its centre: a lift in a shaft hangs 40 deep, a position in millimetres is 100 away.
FAR = 50.0
ROUND_OFF = 1e-9  # of a direction, and relative to the frame's extent
UNHELD = 0.01  # relative to the weight: poses and limits in files are rounded
OFF_ANCHOR = 0.05  # the same for cables over pulleys, which leave the frame beside their anchors


def no_length(setup: Setup) -> Iterator[Finding]:
    """Yield cables without length at home; at the start of a run this is an error."""
    home = setup.robot.home
    if home is None:
        return
    for cable, chord in zip(setup.robot.cables, _chords(setup, home[:3], rotations.matrix(home[3:])), strict=True):
        if np.linalg.norm(chord) < tolerances.LENGTH:
            text = f"cable '{cable.name}' has no length here: its two anchors coincide, so it has no direction"
            yield (*setup.root, "home", "position"), text


def one_sided(setup: Setup) -> Iterator[Finding]:
    """Yield start poses at which all cables pull to one side, and gravity does not pull to the other.

    Checked are the world axes and the mean direction of the cables. Scenarios with external loads are excluded.
    """
    robot = setup.robot
    free = np.array([name in robot.dof for name in DOF_NAMES[:3]])
    if not free.any() or may_hold(setup):
        return
    for path, position, attitude in setup.starts():
        chords = _chords(setup, position, rotations.matrix(attitude)) * free
        lengths = np.linalg.norm(chords, axis=1)
        if lengths.min() < tolerances.LENGTH:
            continue
        pulls = chords / lengths[:, None]
        mean = pulls.mean(axis=0)
        size = float(np.linalg.norm(mean))
        sides = [*np.eye(3), *-np.eye(3), *([mean / size] if size > ROUND_OFF else [])]
        for side in sides:
            if np.all(pulls @ side > _slack(robot)) and setup.gravity * free @ side > -ROUND_OFF:
                axis = "[" + ", ".join(f"{part + 0.0:.3g}" for part in side) + "]"
                count = "its cable pulls" if robot.m == 1 else f"all {robot.m} cables pull"
                yield path, f"{count} the platform along {axis} (x, y, z) here, and nothing pulls it back"
                break


def too_weak(setup: Setup) -> Iterator[Finding]:
    """Yield start poses at which no tensions within the limits balance the weight.

    Excluded are robots with fewer cables than degrees of freedom and those with pulleys (see `cdpr info`), scenarios
    with external loads, and those in which an event changes limits at the start.
    """
    robot = setup.robot
    if setup.run is not None and any(
        event.changes_limits and first_sample(event.time, setup.run.simulation.control_step) == 0
        for event in setup.run.events
    ):
        return
    if setup.run is not None and setup.run.controlled:
        robot = replace(robot, dof=setup.run.controlled)
    if robot.m < robot.n or may_hold(setup) or _slack(robot) > ROUND_OFF:
        return
    size = robot.platform.mass * float(np.linalg.norm(setup.gravity))
    slack = UNHELD * size + ROUND_OFF * max(np.abs(robot.tension_min).max(), np.abs(robot.tension_max).max())
    what, whole = ("hold the platform's weight", f" of {size:.4g} N") if size > 0.0 else ("are in balance", "")
    for path, position, attitude in setup.starts():
        if np.linalg.norm(_chords(setup, position, rotations.matrix(attitude)), axis=1).min() < tolerances.LENGTH:
            continue
        left = unheld(robot, position, attitude, setup.gravity)
        if left > slack:
            text = f"the nearest leave {left:.4g} N{whole}, moments taken at the characteristic length"
            yield path, f"no tensions within the limits {what} here: {text}"


def outside(setup: Setup) -> Iterator[Finding]:
    """Yield positions outside the frame's anchors, except those below a suspended robot."""
    robot, anchors = setup.robot, setup.robot.anchors[:, :3]
    if may_hold(setup):
        return
    low, high = anchors.min(axis=0), anchors.max(axis=0)
    slack = _slack(robot) * setup.extent + tolerances.HELD
    paths, positions, turned = setup.places
    # A platform may be longer than the frame is wide: both its origin and its centre of mass must be outside.
    masses = positions + turned @ robot.platform.center_of_mass
    below = np.maximum(positions, masses) < low - slack
    above = np.minimum(positions, masses) > high + slack
    flat = high - low <= LEVEL * setup.extent  # includes a single anchor
    hangs = flat & (((setup.gravity < 0.0) & below) | ((setup.gravity > 0.0) & above))
    free = np.array([name in robot.dof for name in DOF_NAMES[:3]])
    for k, i in np.argwhere((below | above) & ~hangs & free):
        axis = DOF_NAMES[i]
        span = f"its anchors go from {axis} = {low[i]:.4g} to {high[i]:.4g} m"
        yield paths[k], f"lies outside the frame: {span}, and here {axis} = {positions[k, i]:.6g} m"


def far_text(robot: Robot, position: Array) -> str:
    """Return a warning if a position (3,), m, is far from the frame, else ""."""
    anchors = robot.anchors[:, :3]
    away, extent = np.linalg.norm(position - anchors.mean(axis=0)), np.linalg.norm(np.ptp(anchors, axis=0))
    if {"x", "y", "z"}.isdisjoint(robot.dof) or not away > FAR * extent > 0.0:
        return ""
    given, metres = (", ".join(f"{part:.6g}" for part in position * unit) for unit in (1.0, 1e-3))
    text = f"lies beyond reach: {away:.4g} m from the middle of the frame's anchors, which are {extent:.4g} m apart"
    return f"{text}; lengths are in metres: [{given}] in millimetres is [{metres}] m"


def far(setup: Setup) -> Iterator[Finding]:
    """Yield positions far from the frame, probably in millimetres."""
    paths, positions, _ = setup.places
    for path, position in zip(paths, positions, strict=True):
        if text := far_text(setup.robot, position):
            yield path, text


def beyond_reach(setup: Setup) -> Iterator[Finding]:
    """Yield positions at which a cable exceeds its length limits.

    Cables over pulleys are excluded, because the length on the pulley counts too.
    """
    robot = setup.robot
    paths, positions, turned = setup.places
    limits = [(cable.length_min, cable.length_max) if cable.exit is None else (None, None) for cable in robot.cables]
    shortest = np.array([0.0 if low is None else low for low, _ in limits])
    longest = np.array([np.inf if high is None else high for _, high in limits])
    if not shortest.any() and not np.isfinite(longest).any():
        return
    lengths = np.linalg.norm(_chords(setup, positions, turned), axis=2)
    short, long = lengths < shortest * (1.0 - ROUND_OFF), lengths > longest * (1.0 + ROUND_OFF)
    for k, i in np.argwhere(short | long):
        limit = f"longer than its length.max, {longest[i]:.6g} m"
        limit = f"shorter than its length.min, {shortest[i]:.6g} m" if short[k, i] else limit
        yield (
            paths[k],
            f"lies beyond reach: cable '{robot.cables[i].name}' would be {lengths[k, i]:.6g} m long, {limit}",
        )


def _chords(setup: Setup, positions: Array, turned: Array) -> Array:
    """Return the vectors from platform to frame anchors, (..., m, 3), m, world, at positions and rotation matrices."""
    anchors = setup.robot.anchors
    arms = anchors[:, 3:] @ np.swapaxes(turned, -1, -2)
    return np.asarray(anchors[:, :3] - positions[..., None, :] - arms)


def _slack(robot: Robot) -> float:
    return ROUND_OFF if all(cable.exit is None for cable in robot.cables) else OFF_ANCHOR


def may_hold(setup: Setup) -> bool:
    """Return True if something besides cables and gravity may support the platform: external loads or rigid legs.

    Upward gravity is reported separately.
    """
    events = setup.run.events if setup.run else ()
    loaded = any(event.wrench_profile(1.0) is not None for event in events)
    return loaded or not setup.robot.unilateral or setup.gravity[2] > 0.0
