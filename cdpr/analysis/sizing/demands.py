"""Figures of each cable, its drum and its motor over a duty."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.sizing.duty import Duty
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
        torque, torque_rms: motor torque at the drum, N m.
        motor_power: largest magnitude, W.
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
    motor_power: Array


ROUNDING = 1e-12  # share of the largest power that is round-off of the rates

LEAST = {"tension_least", "shortest"}  # the worst of several duties is the smallest value; of all others the largest


def demands(duty: Duty) -> Demands:
    """Return the figures of a duty; infeasible samples are ignored."""
    nothing, good = np.full(duty.robot.m, np.nan), duty.feasible
    radius = drum_radii(duty.robot)
    known: dict[str, Array] = {}
    if good.any():
        length, tension = duty.length[good], duty.tension[good]
        known |= {"tension": _largest(tension), "tension_least": -_largest(-tension)}
        known |= {"shortest": length.min(axis=0), "longest": length.max(axis=0)}
        known["turns"] = (known["longest"] - known["shortest"]) / (2.0 * math.pi * radius)
        if duty.time is None or duty.rate is None:
            known["torque"] = radius * known["tension"]
        else:
            tension = np.where(good[:, None], duty.tension, np.nan)
            known |= _in_motion(duty.robot, tension, duty.rate, duty.time, radius, good)
    return Demands(**{part.name: known.get(part.name, nothing) for part in fields(Demands)})


def drum_radii(robot: Robot) -> Array:
    """Return the drum radii, (m,), m; NaN for cables without a drum."""
    return np.array([math.nan if cable.winch is None else cable.winch.drum_radius for cable in robot.cables])


def _in_motion(
    robot: Robot, tension: Array, rate: Array, time: Array, radius: Array, good: NDArray[np.bool_]
) -> dict[str, Array]:
    """Return the figures that require time.

    Tensions (K, m) are NaN at ignored samples, for which `good` (K,) is False.
    """
    acceleration = np.gradient(rate, time, axis=0)
    speed, change = np.abs(rate[good]).max(axis=0), np.abs(acceleration[good]).max(axis=0)
    power = -tension * rate
    power[np.abs(power) <= ROUNDING * np.nanmax(np.abs(power))] = 0.0  # at rest
    driving, braking = np.maximum(power, 0.0), np.maximum(-power, 0.0)
    torque = _torque(robot, tension, rate, acceleration)
    return {
        "tension_rms": _rms(tension, time),
        "speed": speed,
        "acceleration": change,
        "driving": _largest(driving),
        "braking": _largest(braking),
        "given": _integral(driving, time),
        "taken": _integral(braking, time),
        "drum_speed": speed / radius,
        "torque": _largest(np.abs(torque)),
        "torque_rms": _rms(torque, time),
        "motor_power": _largest(np.abs(torque * rate / radius)),
    }


def _torque(robot: Robot, tension: Array, rate: Array, acceleration: Array) -> Array:
    """Return the motor torques at the drums, (K, m), N m: cable, inertia and friction, positive when winding in."""
    torque = np.full(tension.shape, np.nan)
    for i, cable in enumerate(robot.cables):
        winch = cable.winch
        if winch is None or not math.isfinite(winch.drum_radius):
            continue
        speed, turning = -rate[:, i] / winch.drum_radius, -acceleration[:, i] / winch.drum_radius
        inertia = winch.inertia if math.isfinite(winch.inertia) else 0.0
        friction = winch.viscous_friction * speed + winch.coulomb_friction * np.tanh(speed / winch.coulomb_speed)
        torque[:, i] = winch.drum_radius * tension[:, i] + inertia * turning + friction
    return torque


def _largest(values: Array) -> Array:
    """Return the largest value of each column; NaN if there is none."""
    return np.asarray(np.where(np.isnan(values).all(axis=0), np.nan, np.nan_to_num(values, nan=-np.inf).max(axis=0)))


def _integral(values: Array, time: Array) -> Array:
    """Return the integral over time of each column by the trapezoidal rule; unknown values count as 0."""
    return np.asarray(np.trapezoid(np.nan_to_num(values), time, axis=0))


def _rms(values: Array, time: Array) -> Array:
    """Return the root mean square of each column over the time in which it is known."""
    known = np.trapezoid(np.isfinite(values).astype(float), time, axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where(known > 0.0, np.sqrt(_integral(values**2, time) / known), np.nan))
