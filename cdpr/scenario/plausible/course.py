"""Checks of the run: gravity, late events, and events without effect."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cdpr.base import tolerances
from cdpr.config.problems import exact
from cdpr.model import DOF_NAMES
from cdpr.scenario.event_checks import beyond
from cdpr.scenario.events import ScenarioEvent
from cdpr.scenario.plausible.setup import Finding, Setup

STRONGEST = 100.0  # m/s^2; sun 274, Jupiter 25, earth in millimetres 9810


def gravity(setup: Setup) -> Iterator[Finding]:
    """Yield gravity that points upwards or is not in m/s^2."""
    if setup.run is None:
        return
    path, size = ("world", "gravity"), float(np.linalg.norm(setup.gravity))
    if setup.gravity[2] > 0.0:
        down = f"[0, 0, {-setup.gravity[2]:g}]"
        yield path, f"points upwards, {exact(setup.gravity[2])} m/s^2 along z: z is up, so the earth's is {down}"
    if size > STRONGEST:
        yield path, f"{size:.4g} m/s^2 is {size / 9.81:.0f} times that of the earth, 9.81 m/s^2"


def after_the_end(setup: Setup) -> Iterator[Finding]:
    """Yield events and motions that start after the end of the run, unless it is marked to end early."""
    if setup.run is None or setup.run.simulation.ends_early:
        return
    end, events = setup.run.simulation.duration, setup.run.events
    for i in beyond(events, setup.run.simulation):
        yield ("events", i), f"happens at {exact(events[i].time)} s, after the end of the run at {exact(end)} s: never"
    start = getattr(setup.motion, "start", 0.0)
    if start >= end:
        yield (
            ("trajectory", "start"),
            f"the motion begins at {exact(start)} s, after the run has ended, at {exact(end)} s",
        )


def late_sensors(setup: Setup) -> Iterator[Finding]:
    """Yield sensors that measure or send nothing new until the end of the run."""
    if setup.run is None or setup.shortened or setup.run.simulation.ends_early:
        return
    end = setup.run.simulation.duration
    for i, sensor in enumerate(setup.run.sensors):
        for key, what in (("delay", "no measurement but the first arrives"), ("period", "it measures once")):
            if (time := getattr(sensor, key)) > end:
                yield ("sensors", i, key), f"{exact(time)} s is longer than the run of {exact(end)} s: {what}"


def of_the_motion(setup: Setup) -> Iterator[Finding]:
    """Yield the remarks of the motion, such as skipped words of its file."""
    if setup.run is None or setup.motion is None:
        return
    for path, text in setup.motion.remarks(setup.begin):
        yield ("trajectory", *path), text


def cut_short(setup: Setup) -> Iterator[Finding]:
    """Yield motions that continue for at least a control step after the run.

    Excluded are runs that are marked to end early, and motions that an event redirects.
    """
    if setup.run is None or setup.shortened or setup.run.simulation.ends_early:
        return
    if any(type(event).redirect is not ScenarioEvent.redirect for event in setup.run.events):
        return
    end, motion = setup.run.simulation.duration, setup.run.trajectory.ends()
    seen = (end + setup.run.simulation.control_step) * (1.0 - tolerances.TIME)
    if motion is not None and motion >= seen and getattr(setup.motion, "start", 0.0) < end:
        text = f"the run ends at {exact(end)} s and the motion at {motion:.9g} s: the rest of it is cut off"
        yield ("simulation", "duration"), text


def taken_by_the_guide(setup: Setup) -> Iterator[Finding]:
    """Yield wrenches without effect because the guide takes them entirely."""
    dof = setup.robot.dof
    for i, event in enumerate(setup.run.events if setup.run else ()):
        swing = event.wrench_profile(1.0)
        acts = [name for name, part in zip(DOF_NAMES, swing.amplitude if swing else (), strict=False) if part != 0.0]
        if acts and not set(acts) & set(dof):
            text = f"acts along {', '.join(acts)} only, where the guide holds the platform: it has no effect"
            yield ("events", i), f"{text}; the robot moves along {', '.join(dof)}"


def bodies_that_do_not_turn(setup: Setup) -> Iterator[Finding]:
    """Yield attached bodies whose centre or inertia has no effect because the platform does not rotate."""
    dof = setup.robot.dof
    if any(name.startswith("r") for name in dof):
        return
    for i, event in enumerate(setup.run.events if setup.run else ()):
        span = event.attachment(1.0)
        if span is None:
            continue
        given = {"centre of mass": span.body.center, "inertia": span.body.inertia}
        idle = " and ".join(name for name, values in given.items() if values.any())
        if idle:
            text = f"the {idle} of the body has no effect: the robot moves along {', '.join(dof)} and does not rotate"
            yield ("events", i), text
