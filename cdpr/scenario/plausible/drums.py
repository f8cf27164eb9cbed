"""Checks of winches: drums that become empty along the motion, large steps of steppers, and weak steppers."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.cables import chain_of
from cdpr.cables.drum import RADIUS
from cdpr.cables.drums import drum_motion, first_emptied
from cdpr.cables.stepper import MICROSTEPS, STALL_TORQUE, STEPPERS, STEPS_PER_TURN
from cdpr.cables.transmission import GEAR_RATIO, GROWTH, REEVING
from cdpr.mechanics.kinematics import lengths
from cdpr.model.robot import Array
from cdpr.scenario.plausible.places import may_hold
from cdpr.scenario.plausible.setup import Finding, Setup
from cdpr.scenario.static_feasibility import weight, wrench_matrix
from cdpr.tension.box_least_squares import nearest_wrench_tension

SHARES = np.linspace(0.0, 1.0, 33)  # of each segment
MOST = 4000  # samples
LARGE_STEP = 0.01  # of the cable: usual microsteps of 200 x 16 in a turn are below 1 mm, and 1e-3 of short cables
UNBALANCED = 0.01  # of the weight, above which it is more than the error of directions to exits over pulleys


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
    steppers, pose = _steppers(setup)
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


def weak_steppers(setup: Setup) -> Iterator[Finding]:
    """Yield steppers that stall under the weight of the platform at the start, with any pretension.

    The load of a stepper at rest is the tension times the radius of its drum over the falls, without losses.
    """
    robot = setup.robot
    steppers, pose = _steppers(setup)
    if not steppers or pose is None or may_hold(setup):
        return
    unwound = lengths(robot, np.concatenate([pose, np.zeros(6)]))[None]
    still = np.zeros(unwound.shape)
    torque = drum_motion(robot, unwound, still, still).per_turn[0]  # per tension, N m/N
    free = np.full(robot.m, np.inf)
    stalling = free.copy()
    stalling[steppers] = [STALL_TORQUE.of(robot.cables[i]) / torque[i] for i in steppers]
    W, wanted = wrench_matrix(robot, pose[:3], pose[3:]), weight(robot, pose[3:], setup.gravity)
    (needed, without), (_, left) = (_nearest(W, wanted, high) for high in (free, stalling))
    if not left - without > UNBALANCED * float(np.linalg.norm(wanted)):
        return
    over = max(steppers, key=lambda i: needed[i] / stalling[i])
    cable = robot.cables[over]
    stall = STALL_TORQUE.of(cable)
    place = ("cables", over) if setup.section.cables[over].winch is not None else ()
    yield (
        (*setup.root, *place, "winch", STALL_TORQUE.key),
        f"too low to hold the platform at the start: cable '{cable.name}' needs about {needed[over]:.3g} N, which is "
        f"{needed[over] * torque[over]:.3g} N m at its drum, and its stepper stalls at {stall:.3g} N m "
        f"({stalling[over]:.3g} N); expected the torque of the motor times {GEAR_RATIO.name}",
    )


def _nearest(W: Array, wanted: Array, high: Array) -> tuple[Array, float]:
    """Return the tensions (m,) of at most `high` (m,) that balance a weight (n,) best, and the rest, N."""
    tension, _ = nearest_wrench_tension(W, wanted, np.zeros(len(high)), high, np.ones(len(wanted)))
    return tension, float(np.linalg.norm(W @ tension - wanted))


def _steppers(setup: Setup) -> tuple[list[int], Array | None]:
    """Return the cables with steppers, and the pose (7,) at the start; None if it is not known."""
    robot = setup.robot
    pose = robot.home if setup.run is None else setup.run.initial.state()[:7]
    return [i for i, each in enumerate(robot.cables) if chain_of(robot, each).winch in STEPPERS], pose
