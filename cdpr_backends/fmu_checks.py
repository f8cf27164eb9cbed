"""What an FMU is asked before a run: is it where the scenario is, and does each cable pull as the robot's does?

A wrong order of cables, a wrong frame, unit or convention shows in one of the two; afterwards it would only be a run
that is wrong.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from cdpr.mechanics import dynamics, kinematics
from cdpr.model import Robot
from cdpr.model.robot import Array

# m, rad, m/s, rad/s: far below what any robot's start is known to, far above what single precision and angles lose.
START_TOLERANCE = 1e-5
# Share of a cable's length: above the deflection by small pulleys, below what exchanged cables or a wrong frame make.
LENGTH_TOLERANCE = 1e-2
NORM_TOLERANCE = 1e-3  # of a quaternion, as everywhere

# The wrench of a cable may differ in direction by this cosine and in size by this factor: what masses that are not
# quite the scenario's, pulleys and the motion within a step do. Other cables, frames and units are further off.
LEAST_COSINE = 0.9
MOST_FACTOR = 5.0
NO_ANSWER = 1e-6  # of the size expected; below it there is no direction

INITIAL = "initial_"  # so the parameters begin that hold the initial state
ELSEWHERE = "it has no parameter for that: set those that it has under `parameters`, or the scenario's `initial`"
START = {
    "position": (slice(0, 3), "m"),
    "quaternion": (slice(3, 7), "1"),
    "velocity": (slice(7, 10), "m/s"),
    "angular_velocity": (slice(10, 13), "rad/s"),
}


def start_fault(robot: Robot, start: Array, state: Array, length: Array | None, filled: Collection[str]) -> str:
    """Say what is wrong with the `state` (13,) that an FMU starts with and its cables' `length` (m,); "" if nothing.

    `start` (13,) is the scenario's; `filled` are the parameters that were set to it.
    """
    norm = float(np.linalg.norm(state[3:7]))
    if not abs(norm - 1.0) <= NORM_TOLERANCE:
        return f"starts with a quaternion {_brief(state[3:7])} of norm {norm:.4g}, not 1: check its order"
    turned = start.copy()
    if state[3:7] @ start[3:7] < 0.0:
        turned[3:7] *= -1.0  # the same attitude
    for name, (span, unit) in START.items():
        said, wanted = state[span], turned[span]
        if not np.abs(said - wanted).max() <= START_TOLERANCE * max(1.0, float(np.abs(wanted).max())):
            remedy = "check the mapping of its signals and their units" if INITIAL + name in filled else ELSEWHERE
            return f"starts with the {name} {_brief(said)}, the scenario with {_brief(wanted)} ({unit}); {remedy}"
    if length is not None:
        ours = kinematics.lengths(robot, start)
        if not (np.abs(length - ours) <= LENGTH_TOLERANCE * ours).all():
            return (
                f"says that its cables are {_brief(length)} m long at the start, the robot's are {_brief(ours)} m: "
                "check signals.cable_order, the units, and that it is an FMU of this robot"
            )
    return ""


def pull_fault(robot: Robot, start: Array, pull: Array, accelerations: Array) -> tuple[str, float]:
    """Say which cable does not pull as the robot's does, "" if none, and how much they pull of what they should.

    accelerations (m, 6): of the origin and angular, world axes, that a tension `pull` (m,) in each cable alone adds at
    the state `start` (13,).
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
