"""Figures of each cable, its drum and its motor over a duty."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.sizing.duty import Duty
from cdpr.base.errors import CdprError
from cdpr.cables.drums import DrumMotion, drum_motion, emptied
from cdpr.cables.motor import motor_readings
from cdpr.cables.transmission import GEAR_RATIO
from cdpr.model.robot import Array, Robot


@dataclass(frozen=True, eq=False)
class Demands:
    """Figures of m cables, each (m,); NaN if there is none, such as for a cable without a drum.

    The power of a cable is the power delivered to the platform: -tension x rate of its length. The power of a motor
    includes the drum's inertia and friction: torque x speed, positive when winding in.

    Attributes:
        tension, tension_rms, tension_least: largest, root mean square and smallest tension, N.
        speed, acceleration: largest magnitudes of the rate and of its finite differences, m/s and m/s^2.
        driving, braking: largest power delivered and absorbed by the cable, W, both positive.
        given, taken: energy out and energy in, J.
        shortest, longest: length from exit to platform, m.
        turns: turns of the drum from the shortest to the longest length.
        drum_speed: largest magnitude, rad/s.
        torque, torque_rms: motor torque about the drum's axis, N m; without time, that at rest.
        motor_speed, motor_torque, motor_torque_rms: the same at the motor's shaft, rad/s and N m.
        motor_power: largest magnitude, W.
        current, current_rms: motor current, A; without time, that at rest.
        voltage: largest magnitude of the motor's voltage, V; without time, that at rest.
        electrical_power, feedback_power: largest electrical power used and fed back by the motor, W, both positive.
        used, regenerated: electrical energy used and fed back, J, each counted per motor.
    """

    tension: Array
    tension_rms: Array
    tension_least: Array
    speed: Array
    acceleration: Array
    driving: Array
    braking: Array
    given: Array
    taken: Array
    shortest: Array
    longest: Array
    turns: Array
    drum_speed: Array
    torque: Array
    torque_rms: Array
    motor_speed: Array
    motor_torque: Array
    motor_torque_rms: Array
    motor_power: Array
    current: Array
    current_rms: Array
    voltage: Array
    electrical_power: Array
    feedback_power: Array
    used: Array
    regenerated: Array


ROUNDING = 1e-12  # share of the largest power that is round-off of the rates

LEAST = {"tension_least", "shortest"}  # the worst of several duties is the smallest value; of all others the largest


def demands(duty: Duty) -> Demands:
    """Return the figures of a duty; infeasible samples are ignored.

    Raises:
        CdprError: if a drum is empty at one of the lengths.
    """
    nothing, good = np.full(duty.robot.m, np.nan), duty.feasible
    known: dict[str, Array] = {}
    if good.any():
        length, tension = duty.length[good], duty.tension[good]
        known |= {"tension": _largest(tension), "tension_least": -_largest(-tension)}
        known |= {"shortest": length.min(axis=0), "longest": length.max(axis=0)}
        if text := emptied(duty.robot, known["longest"]):
            raise CdprError(f"{duty.name}: {text}")
        known["turns"] = drum_turns(duty.robot, known["shortest"], known["longest"])
        if duty.time is None or duty.rate is None:
            still = np.zeros(length.shape)
            torque = drum_motion(duty.robot, length, still, still).per_turn * tension
            current, voltage, _ = motor_readings(duty.robot, torque, still)
            known |= {"torque": _largest(torque), "current": _largest(current), "voltage": _largest(voltage)}
        else:
            tension = np.where(good[:, None], duty.tension, np.nan)
            winch = None if duty.winch_tension is None else np.where(good[:, None], duty.winch_tension, np.nan)
            known |= _in_motion(duty.robot, tension, winch, duty.length, duty.rate, duty.time, good)
        known |= _at_the_shaft(duty.robot, known)
    return Demands(**{part.name: known.get(part.name, nothing) for part in fields(Demands)})


def drum_turns(robot: Robot, shortest: Array, longest: Array) -> Array:
    """Return the turns of the drums, (m,), between lengths (m,) [m]; NaN for cables without a drum."""
    still = np.zeros((2, robot.m))
    angle = drum_motion(robot, np.array([shortest, longest]), still, still).angle
    return np.asarray((angle[0] - angle[1]) / (2.0 * math.pi))


def _at_the_shaft(robot: Robot, known: Mapping[str, Array]) -> dict[str, Array]:
    """Return speeds and torques of the motors' shafts."""
    ratio = np.array([GEAR_RATIO.of(cable, math.nan) for cable in robot.cables])
    found = {"motor_torque": known["torque"] / ratio}
    if "drum_speed" in known:
        found |= {"motor_speed": known["drum_speed"] * ratio, "motor_torque_rms": known["torque_rms"] / ratio}
    return found


def _in_motion(
    robot: Robot,
    tension: Array,
    winch_tension: Array | None,
    length: Array,
    rate: Array,
    time: Array,
    good: NDArray[np.bool_],
) -> dict[str, Array]:
    """Return the figures that require time.

    Tensions (K, m) are NaN at ignored samples, for which `good` (K,) is False. Those at the winches default to those at
    the platform.
    """
    acceleration = np.gradient(rate, time, axis=0)
    speed, change = np.abs(rate[good]).max(axis=0), np.abs(acceleration[good]).max(axis=0)
    power = -tension * rate
    power[np.abs(power) <= ROUNDING * np.nanmax(np.abs(power))] = 0.0  # at rest
    driving, braking = np.maximum(power, 0.0), np.maximum(-power, 0.0)
    drums = drum_motion(robot, length, rate, acceleration)
    torque = _torque(robot, tension if winch_tension is None else winch_tension, drums)
    current, voltage, electrical = motor_readings(robot, torque, drums.speed)
    used, regenerated = np.maximum(electrical, 0.0), np.maximum(-electrical, 0.0)
    return {
        "tension_rms": _rms(tension, time),
        "speed": speed,
        "acceleration": change,
        "driving": _largest(driving),
        "braking": _largest(braking),
        "given": _integral(driving, time),
        "taken": _integral(braking, time),
        "drum_speed": np.abs(drums.speed[good]).max(axis=0),
        "torque": _largest(np.abs(torque)),
        "torque_rms": _rms(torque, time),
        "motor_power": _largest(np.abs(torque * drums.speed)),
        "current": _largest(np.abs(current)),
        "current_rms": _rms(current, time),
        "voltage": _largest(np.abs(voltage)),
        "electrical_power": _largest(used),
        "feedback_power": _largest(regenerated),
        "used": _known(_integral(used, time), electrical),
        "regenerated": _known(_integral(regenerated, time), electrical),
    }


def _torque(robot: Robot, tension: Array, drums: DrumMotion) -> Array:
    """Return the motor torques about the drums' axes, (K, m), N m, positive when winding in.

    They consist of cable, losses of the transmission, inertia and friction.
    """
    torque = np.full(tension.shape, np.nan)
    for i, cable in enumerate(robot.cables):
        winch = cable.winch
        if winch is None or not math.isfinite(winch.drum_radius):
            continue
        speed = drums.speed[:, i]
        inertia = winch.inertia if math.isfinite(winch.inertia) else 0.0
        friction = winch.viscous_friction * speed + winch.coulomb_friction * np.tanh(speed / winch.coulomb_speed)
        cable_torque = drums.per_turn[:, i] * tension[:, i] * drums.load[:, i]
        torque[:, i] = cable_torque + inertia * drums.acceleration[:, i] + friction
    return torque


def _largest(values: Array) -> Array:
    """Return the largest value of each column; NaN if there is none."""
    return np.asarray(np.where(np.isnan(values).all(axis=0), np.nan, np.nan_to_num(values, nan=-np.inf).max(axis=0)))


def _integral(values: Array, time: Array) -> Array:
    """Return the integral over time of each column by the trapezoidal rule; unknown values count as 0."""
    return np.asarray(np.trapezoid(np.nan_to_num(values), time, axis=0))


def _known(figures: Array, values: Array) -> Array:
    """Return figures (m,), NaN for columns of `values` (K, m) without a known value."""
    return np.asarray(np.where(np.isfinite(values).any(axis=0), figures, np.nan))


def _rms(values: Array, time: Array) -> Array:
    """Return the root mean square of each column over the time in which it is known."""
    known = np.trapezoid(np.isfinite(values).astype(float), time, axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where(known > 0.0, np.sqrt(_integral(values**2, time) / known), np.nan))
