"""Messages for impossible states."""

from __future__ import annotations

import math

import numpy as np

from cdpr.cables.drums import emptied
from cdpr.mechanics.kinematics import lengths
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.model.rotations import from_axis_angle, matrix, multiply

NOT_FINITE, NO_UNIT, TOO_FAST, JUMPED, NO_LENGTH, NO_LENGTH_NOMINAL = range(1, 7)

FAULTS = {
    NOT_FINITE: "the state is not finite",
    NO_UNIT: "the attitude quaternion is not of unit length",
    TOO_FAST: "the platform moves absurdly fast",
    JUMPED: "the pose jumped by more than its velocity explains; the engine may have been reset",
    NO_LENGTH: "a cable has no length",
    NO_LENGTH_NOMINAL: "a cable of the controller's nominal robot has no length",
}

LENGTH_MIN = 1e-9  # m; round-off dominates the direction of a shorter cable

PAID_OUT = 1e-3  # share of its length by which a cable may be longer after the sample before

# A state that is not finite gives no cause. The states of an integrator's stages are searched for on the motion of the
# previous sample, for two control periods: the acceleration may have reached them sooner.
AHEAD = np.linspace(0.0, 2.0, 201)


def fault_message(
    fault: int, robot: Robot, perceived: Robot | None, state: Array, before: Array | None, period: float
) -> str:
    """Return a message for a faulty state (13,), with the cable that causes it, if known.

    `perceived` is the robot that the controller uses; NO_LENGTH_NOMINAL concerns it, at the state that it sees.
    `before` (13,) is the state of the previous sample, a control `period` (s) earlier, if there was one.
    """
    if fault == NOT_FINITE and before is not None and np.isfinite(before).all():
        way = next(filter(None, (without_length(robot, _after(before, share * period)) for share in AHEAD)), "")
        cause = f"; {FAULTS[NO_LENGTH]} along the motion of the platform{way}" if way else ""
        if not cause and (empty := emptied(robot, lengths(robot, before) * (1.0 + PAID_OUT))):
            cause = f"; {empty}"
        return f"{FAULTS[fault]}{cause} (the sample before: {_brief(before)})"
    whose = {NO_LENGTH: robot, NO_LENGTH_NOMINAL: perceived}.get(fault)
    which = "" if whose is None else without_length(whose, state)
    return f"{FAULTS[fault]}{which} ({_brief(state)})"


def without_length(robot: Robot, state: Array) -> str:
    """Return a message for cables without length at a state (13,); "" if all have one."""
    tips = state[:3] + robot.anchors[:, 3:] @ matrix(state[3:7]).T
    found = ""
    for cable, tip in zip(robot.cables, tips, strict=True):
        why = cable.exit.obstacle(cable.frame.tolist(), tip.tolist()) if cable.exit else ""
        if not why and not np.linalg.norm(tip - cable.frame) > LENGTH_MIN:
            why = "its ends lie in one point"
        found += f": of '{cable.name}' {why}" if why else ""
    return found


def _after(state: Array, time: float) -> Array:
    """Return the state (13,) after some time (s) with constant velocities."""
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
