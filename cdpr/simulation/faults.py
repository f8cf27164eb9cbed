"""States that cannot be true: their numbers, and what is told of them."""

from __future__ import annotations

import math

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.model.rotations import from_axis_angle, matrix, multiply

NOT_FINITE, NO_UNIT, TOO_FAST, JUMPED, NO_LENGTH, NO_LENGTH_BELIEVED = range(1, 7)

FAULTS = {
    NOT_FINITE: "the state is not finite",
    NO_UNIT: "the attitude quaternion is not of unit length",
    TOO_FAST: "the platform moves absurdly fast",
    JUMPED: "the pose jumped, which its velocity does not explain; the engine may have reset itself",
    NO_LENGTH: "a cable has no length",
    NO_LENGTH_BELIEVED: "a cable has no length where the controller believes its ends to be",
}

LENGTH_MIN = 1e-9  # m; the direction of a shorter cable is rounding

# A state that is not finite says nothing of where it came from. What a stage of the integrator saw is looked for on the
# way on which the sample before moved, for two control periods: its acceleration may have led there sooner.
AHEAD = np.linspace(0.0, 2.0, 201)


def told(fault: int, robot: Robot, believed: Robot | None, state: Array, before: Array | None, period: float) -> str:
    """Return what is wrong with a state (13,), and which cable is the cause, where one is.

    `before` (13,) is the state at the sample before, a control `period` (s) ago, if there was one.
    """
    if fault == NOT_FINITE and before is not None and np.isfinite(before).all():
        way = next(filter(None, (without_length(robot, _after(before, share * period)) for share in AHEAD)), "")
        cause = f"; {FAULTS[NO_LENGTH]} where the platform was going{way}" if way else ""
        return f"{FAULTS[fault]}{cause} (the sample before: {_brief(before)})"
    whose = {NO_LENGTH: robot, NO_LENGTH_BELIEVED: believed}.get(fault)
    which = "" if whose is None else without_length(whose, state)
    return f"{FAULTS[fault]}{which} ({_brief(state)})"


def without_length(robot: Robot, state: Array) -> str:
    """Tell which cables have no length at a state (13,), and why; "" where all have one."""
    tips = state[:3] + robot.anchors[:, 3:] @ matrix(state[3:7]).T
    found = ""
    for cable, tip in zip(robot.cables, tips, strict=True):
        why = cable.exit.obstacle(cable.frame.tolist(), tip.tolist()) if cable.exit else ""
        if not why and not np.linalg.norm(tip - cable.frame) > LENGTH_MIN:
            why = "its ends lie in one point"
        found += f": of '{cable.name}' {why}" if why else ""
    return found


def _after(state: Array, time: float) -> Array:
    """A state (13,) as its velocities, kept for some time (s), move it."""
    moved = state.copy()
    moved[:3] += time * state[7:10]
    spin = float(np.linalg.norm(state[10:]))
    if spin > 0.0:
        moved[3:7] = multiply(from_axis_angle(state[10:] / spin, spin * time), state[3:7])
    return moved


def _brief(state: Array) -> str:
    parts = {"position": (0, "m"), "velocity": (7, "m/s"), "angular velocity": (10, "rad/s")}
    return ", ".join(f"{name} {_vector(state[at : at + 3])} {unit}" for name, (at, unit) in parts.items())


def _vector(values: Array) -> str:
    return "[" + ", ".join(f"{value:.4g}" if math.isfinite(value) else str(value) for value in values) + "]"
