"""Checks of an FMU before a run: its initial state, and the direction in which each cable pulls.

One of the two checks detects a wrong order of cables, frame, unit or convention. Otherwise, the run would be wrong
without a message.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from cdpr.mechanics import dynamics, kinematics
from cdpr.model import Robot
from cdpr.model.robot import Array

# [m, rad, m/s, rad/s], far below the accuracy of a real start, and far above the errors of single precision and angles
START_TOLERANCE = 1e-5
# Share of a cable's length, above the effect of small pulleys, and below that of swapped cables or a wrong frame.
LENGTH_TOLERANCE = 1e-2
NORM_TOLERANCE = 1e-3  # tolerance of a quaternion's norm, as everywhere

# Limits of the difference between the wrench of a cable and the expected one: cosine of the angle and factor. Slightly
# # different masses, pulleys and the motion within a step stay within them. Other cables, frames and units exceed them.
LEAST_COSINE = 0.9
MOST_FACTOR = 5.0
NO_ANSWER = 1e-6  # share of the expected size below which there is no direction

INITIAL = "initial_"  # prefix of the parameters for the initial state
ELSEWHERE = "it has no parameter for that: set those that it has under `parameters`, or the scenario's `initial`"
START = {
    "position": (slice(0, 3), "m"),
    "quaternion": (slice(3, 7), "1"),
    "velocity": (slice(7, 10), "m/s"),
    "angular_velocity": (slice(10, 13), "rad/s"),
}


def start_fault(robot: Robot, start: Array, state: Array, length: Array | None, filled: Collection[str]) -> str:
    """Return the error in the initial `state` (13,) of an FMU and the `length` (m,) of its cables, "" if there is none.

    `start` (13,) is the initial state of the scenario; `filled` are the parameters that were set from it.
    """
    norm = float(np.linalg.norm(state[3:7]))
    if not abs(norm - 1.0) <= NORM_TOLERANCE:
        return f"starts with a quaternion {_brief(state[3:7])} of norm {norm:.4g}, not 1: check its order"
    turned = start.copy()
    if state[3:7] @ start[3:7] < 0.0:
        turned[3:7] *= -1.0  # same attitude
    for name, (span, unit) in START.items():
        given, wanted = state[span], turned[span]
        if not np.abs(given - wanted).max() <= START_TOLERANCE * max(1.0, float(np.abs(wanted).max())):
            remedy = "check the mapping of its signals and their units" if INITIAL + name in filled else ELSEWHERE
            return f"starts with the {name} {_brief(given)}, the scenario with {_brief(wanted)} ({unit}); {remedy}"
    if length is not None:
        ours = kinematics.lengths(robot, start)
        if not (np.abs(length - ours) <= LENGTH_TOLERANCE * ours).all():
            return (
                f"its cables are {_brief(length)} m long at the start, the robot's are {_brief(ours)} m: "
                "check signals.cable_order, the units, and that it is an FMU of this robot"
            )
    return ""


def pull_fault(robot: Robot, start: Array, pull: Array, accelerations: Array) -> tuple[str, float]:
    """Return the error of a cable that does not pull like that of the robot, "" if none, and the share of the pull.

    The share is the median ratio of the pull to the expected one. `accelerations` (m, 6) are those of the origin and
    angular, in world axes, that a tension `pull` (m,) in each cable alone adds at the state `start` (13,).
    """
    rows = robot.rows
    scale = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[rows]
    expected = kinematics.wrench_matrix(robot, start)[rows].T * pull[:, None] * scale
    rest = dynamics.required_wrench(robot, start, np.zeros(3))
    answers = [dynamics.required_wrench(robot, start, np.zeros(3), a[:3], a[3:]) - rest for a in accelerations]
    found = np.array(answers)[:, rows] * scale
    sizes, wanted = np.linalg.norm(found, axis=1), np.linalg.norm(expected, axis=1)
    share = float(np.median(sizes / wanted))
    cosines = (found @ expected.T) / np.maximum(np.outer(sizes, wanted), np.finfo(float).tiny)
    for i, cable in enumerate(robot.cables):
        if sizes[i] > NO_ANSWER * wanted[i] and not cosines[i, i] >= LEAST_COSINE:
            like = int(np.argmax(cosines[i]))
            hint = f", but as '{robot.cables[like].name}' would" if cosines[i, like] >= LEAST_COSINE else ""
            return (
                f"does not pull along cable '{cable.name}' when that is tensioned{hint} (cosine {cosines[i, i]:.2f}): "
                "check signals.cable_order, frames and signs, and that it is an FMU of this robot"
            ), share
    if not share <= MOST_FACTOR:
        return f"pulls {share:.3g} times as much as its cables are tensioned: check the unit of its input", share
    return "", share


def _brief(values: Array) -> str:
    return "[" + ", ".join(f"{value:.4g}" for value in values) + "]"
