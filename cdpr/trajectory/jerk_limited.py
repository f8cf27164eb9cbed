"""Time-optimal straight moves between stops with limited velocity, acceleration and jerk.

On a straight line with the shortest rotation, position and attitude share one scalar from 0 to 1. Its fastest motion
from rest to rest is known in closed form: up to seven phases of constant jerk (Biagiotti and Melchiorri 2008, section
3.4). Libraries such as ruckig solve the harder problem of arbitrary boundary values per axis; its community edition
also stops at inner points. It is the oracle of our tests.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdpr.model import rotations
from cdpr.model.frozen import given_array, given_number
from cdpr.model.robot import Array
from cdpr.trajectory.trajectory import COLUMNS, Trajectory, hold

# Smaller distances (m) and angles (rad) are zero: points entered twice differ only by rounding.
NO_MOVE = 1e-12


@dataclass(frozen=True)
class Limits:
    """Largest norms for translation, m/s, m/s^2, m/s^3, or for rotation, rad/s, rad/s^2, rad/s^3."""

    velocity: float
    acceleration: float
    jerk: float

    def __post_init__(self) -> None:
        for name, value in list(vars(self).items()):
            given_number(value, f"Limits({name}=)", above=0.0, finite=False)


@dataclass(frozen=True, eq=False)
class Stop:
    """Pose at which the motion stops."""

    position: Array  # (3,), m, world
    orientation: Array  # (4,) quaternion w, x, y, z
    pause: float = 0.0  # s

    def __post_init__(self) -> None:
        vars(self).update(
            position=given_array(self.position, (3,), "Stop(position=)"),
            orientation=given_array(self.orientation, (4,), "Stop(orientation=)"),
            pause=given_number(self.pause, "Stop(pause=)", least=0.0),
        )


def stop_to_stop(start: float, stops: Sequence[Stop], limits: Limits, angular: Limits | None) -> Trajectory:
    """Return the motion from each stop to the next.

    Args:
        start: start time, s.
        stops: the stops.
        limits: limits of the translation.
        angular: limits of the rotation; may be None if all stops have the same attitude.

    Raises:
        ValueError: if the limits of the rotation are missing.
    """
    rows: list[Array] = []
    time = start
    here = stops[0]
    for k, there in enumerate(stops):
        if k > 0:
            time = _move(rows, time, here, there, limits, angular)
        if there.pause > 0.0:
            rows.append(_segment(time, there.pause, there.position, there.orientation))
            time += there.pause
        here = there
    return Trajectory(np.array(rows)) if rows else hold(here.position, here.orientation)


def fastest(limits: Limits) -> list[tuple[float, float]]:
    """Return (duration, jerk) of the phases of the fastest motion from 0 to 1, from rest to rest."""
    v, a, j = limits.velocity, limits.acceleration, limits.jerk
    ramp = min(a / j, math.sqrt(v / j))  # time of rising acceleration
    rise = ramp + v / (j * ramp)  # time of rising velocity
    cruise = 1.0 / v - rise
    if cruise < 0.0:
        cruise = 0.0
        ramp = min(a / j, (0.5 / j) ** (1.0 / 3.0))
        rise = 0.5 * ramp + math.sqrt(0.25 * ramp**2 + 1.0 / (j * ramp))
    steady = max(rise - 2.0 * ramp, 0.0)
    return [(ramp, j), (steady, 0.0), (ramp, -j), (cruise, 0.0), (ramp, -j), (steady, 0.0), (ramp, j)]


def _move(rows: list[Array], time: float, here: Stop, there: Stop, limits: Limits, angular: Limits | None) -> float:
    """Append the phases of one move; return its end time."""
    step = np.asarray(there.position) - here.position
    turn = rotations.rotation_vector(rotations.multiply(rotations.conjugate(here.orientation), there.orientation))
    distance, angle = float(np.linalg.norm(step)), float(np.linalg.norm(turn))
    shares: list[Limits] = []
    for length, given in ((distance, limits), (angle, angular)):
        if length > NO_MOVE:
            if given is None:
                raise ValueError("a motion that turns needs limits of its rotation")
            shares.append(Limits(given.velocity / length, given.acceleration / length, given.jerk / length))
    if not shares:
        return time
    together = Limits(*(min(getattr(share, name) for share in shares) for name in Limits.__dataclass_fields__))
    s = v = a = 0.0
    for duration, jerk in fastest(together):
        if duration == 0.0:
            continue
        c1, c2, c3 = v * duration, 0.5 * a * duration**2, jerk * duration**3 / 6.0
        attitude = rotations.multiply(here.orientation, rotations.from_axis_angle(turn / (angle or 1.0), angle * s))
        row = _segment(time, duration, here.position + s * step, attitude)
        powers = np.array([c1, c2, c3])
        row[2:20].reshape(3, 6)[:, 1:4] = np.outer(step, powers)
        row[20:38].reshape(3, 6)[:, 1:4] = np.outer(turn, powers)
        rows.append(row)
        s, v, a = s + c1 + c2 + c3, v + a * duration + 0.5 * jerk * duration**2, a + jerk * duration
        time += duration
    return time


def _segment(time: float, duration: float, position: Array, orientation: Array) -> Array:
    """Return a segment at rest."""
    row = np.zeros(COLUMNS)
    row[:2] = time, duration
    row[2:20:6] = position
    row[38:] = orientation
    return row
