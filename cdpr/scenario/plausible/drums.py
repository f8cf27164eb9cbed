"""Checks of winches: drums that become empty along the motion, and large steps of steppers."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.cables import chain_of
from cdpr.cables.drum import RADIUS
from cdpr.cables.drums import first_emptied
from cdpr.cables.stepper import MICROSTEPS, STEPPERS, STEPS_PER_TURN
from cdpr.cables.transmission import GEAR_RATIO, GROWTH, REEVING
from cdpr.mechanics.kinematics import lengths
from cdpr.scenario.plausible.setup import Finding, Setup

SHARES = np.linspace(0.0, 1.0, 33)  # of each segment
MOST = 4000  # samples
LARGE_STEP = 0.01  # of the cable: usual microsteps of 200 x 16 in a turn are below 1 mm, and 1e-3 of short cables


def empty_drums(setup: Setup) -> Iterator[Finding]:
    """Yield drums whose radius shrinks to nothing along the desired motion."""
    robot = setup.robot
    if setup.run is None or setup.desired is None or not any(GROWTH.of(each, 0.0) > 0.0 for each in robot.cables):
        return
    try:
        motion = setup.desired()
    except CdprError:
        return  # reported by the run's own checks
    end = setup.run.simulation.duration
    times = np.clip(motion.segments[:, :1] + motion.segments[:, 1:2] * SHARES, 0.0, end)
    times = np.unique(np.append(times, [0.0, end]))
    times = times[:: -(-len(times) // MOST)]
    found = first_emptied(robot, np.array([lengths(robot, motion.sample(time)[:13]) for time in times.tolist()]))
    if found is None:
        return
    k, i, text = found
    own = setup.section.cables[i].winch
    place = ("cables", i) if own is not None and GROWTH.key in own.model_fields_set else ()
    yield (*setup.root, *place, "winch", GROWTH.key), f"at {times[k]:.4g} s of the motion, {text}"


def large_steps(setup: Setup) -> Iterator[Finding]:
    """Yield steppers whose microsteps are large for the cable at the start."""
    robot = setup.robot
    steppers = [i for i, each in enumerate(robot.cables) if chain_of(robot, each).winch in STEPPERS]
    pose = robot.home if setup.run is None else setup.run.initial.state()[:7]
    if not steppers or pose is None:
        return
    unwound = lengths(robot, np.concatenate([pose, np.zeros(6)]))
    for i in steppers:
        cable = robot.cables[i]
        turn = 2.0 * np.pi * RADIUS.of(cable) / REEVING.of(cable)
        step = turn / (STEPS_PER_TURN.of(cable) * MICROSTEPS.of(cable) * GEAR_RATIO.of(cable))
        if step > LARGE_STEP * unwound[i]:
            place = ("cables", i) if setup.section.cables[i].winch is not None else ()
            yield (
                (*setup.root, *place, "winch", STEPS_PER_TURN.key),
                f"one step of cable '{cable.name}' is {step:.4g} m, and the cable {unwound[i]:.4g} m long at the "
                f"start: expected at most {100.0 * LARGE_STEP:g} % of it; check {RADIUS.name}, {STEPS_PER_TURN.name}, "
                f"{MICROSTEPS.name} and {GEAR_RATIO.name}",
            )
            return
