"""Motions through knots.

Position: each coordinate is the quintic with the given position, velocity and acceleration at both ends of a segment.
(Equations 6.19 to 6.21 of the thesis for the same polynomial are misprinted; these were derived independently.)

Attitude: between knots at rest the rotation vector keeps its direction, so the platform takes the shortest rotation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cdpr.model import rotations
from cdpr.model.frozen import given_array, given_number
from cdpr.model.robot import Array
from cdpr.trajectory.rotation_rates import rotation_vector_rates
from cdpr.trajectory.spline import minimum_jerk
from cdpr.trajectory.trajectory import Trajectory

FEW = 32  # knots; the attitudes of longer motions are not kept


@dataclass(frozen=True, eq=False)
class Knot:
    """Desired pose and rates at a time; world axes.

    Velocities and accelerations that are None are computed: zero at the first and last knot, minimum-jerk in between.
    """

    time: float  # s
    position: Array  # (3,), m
    orientation: Array  # (4,) quaternion w, x, y, z
    velocity: Array | None = None  # (3,), m/s
    angular_velocity: Array | None = None  # (3,), rad/s
    acceleration: Array | None = None  # (3,), m/s^2
    angular_acceleration: Array | None = None  # (3,), rad/s^2

    def __post_init__(self) -> None:
        values: dict[str, object] = {
            "time": given_number(self.time, "Knot(time=)"),
            "position": given_array(self.position, (3,), "Knot(position=)"),
            "orientation": given_array(self.orientation, (4,), "Knot(orientation=)"),
        }
        for name in ("velocity", "angular_velocity", "acceleration", "angular_acceleration"):
            if (rate := getattr(self, name)) is not None:
                values[name] = given_array(rate, (3,), f"Knot({name}=)")
        vars(self).update(values)


def through(knots: Sequence[Knot]) -> Trajectory:
    """Return a motion through two or more knots with increasing times and continuous acceleration."""

    def rows(values: list[Array | None]) -> Array:
        return np.array([np.full(3, np.nan) if value is None else value for value in values], dtype=np.float64)

    return interpolate(
        np.array([knot.time for knot in knots]),
        np.array([knot.position for knot in knots], dtype=np.float64),
        np.array([knot.orientation for knot in knots], dtype=np.float64),
        rows([knot.velocity for knot in knots]),
        rows([knot.angular_velocity for knot in knots]),
        rows([knot.acceleration for knot in knots]),
        rows([knot.angular_acceleration for knot in knots]),
    )


def interpolate(
    times: Array,
    position: Array,
    orientation: Array,
    velocity: Array | None = None,
    angular_velocity: Array | None = None,
    acceleration: Array | None = None,
    angular_acceleration: Array | None = None,
) -> Trajectory:
    """Return a motion through K >= 2 knots.

    Rates that are None or NaN are computed as for a `Knot`.

    Args:
        times: (K,), s, increasing.
        position: (K, 3), m.
        orientation: (K, 4), unit quaternions.
        velocity: (K, 3), m/s, world axes.
        angular_velocity: (K, 3), rad/s, world axes.
        acceleration: (K, 3), m/s^2, world axes.
        angular_acceleration: (K, 3), rad/s^2, world axes.

    Raises:
        ValueError: if there are fewer than two knots or times do not increase.
    """
    if len(times) < 2 or not np.all(np.diff(times) > 0.0):
        raise ValueError("a motion needs two or more knots with increasing times")
    v, a = minimum_jerk(times, position, _ends_at_rest(velocity, times), _ends_at_rest(acceleration, times))
    rates = _ends_at_rest(angular_velocity, times), _ends_at_rest(angular_acceleration, times)
    given = [np.asarray(each, dtype=np.float64).tobytes() for each in (times, orientation, *rates)]
    turning = (_turning_of if len(times) <= FEW else _turning_of.__wrapped__)(*given)
    return Trajectory(np.hstack([_moving(times, position, v, a), turning]))


@lru_cache(maxsize=8)  # many motions, such as of the cases of a study, differ in positions only
def _turning_of(*given: bytes) -> Array:
    """Return the columns of the attitude from times (K,), orientation (K, 4), and angular rates (K, 3), world axes."""
    times, *others = map(np.frombuffer, given)
    orientation, velocity, acceleration = (each.reshape(len(times), -1) for each in others)
    # In platform axes the rotation vector of a turn is constant, so the sum of turns is smoothed like a position.
    spin, spin_rate = minimum_jerk(
        times,
        np.concatenate([np.zeros((1, 3)), np.cumsum(_turns(orientation), axis=0)]),
        _to_body(orientation, velocity),
        _to_body(orientation, acceleration),
    )
    return _turning(times, orientation, spin, spin_rate)


def join(times: Array, x: Array, v: Array, a: Array, orientation: Array, spin: Array, spin_rate: Array) -> Trajectory:
    """Return a motion through complete knots; the platform takes the shorter rotation between two knots.

    Args:
        times: (K,), s.
        x: (K, 3), position, m, world axes.
        v: (K, 3), velocity, m/s.
        a: (K, 3), acceleration, m/s^2.
        orientation: (K, 4), quaternions.
        spin: (K, 3), angular velocity, rad/s, platform axes.
        spin_rate: (K, 3), angular acceleration, rad/s^2, platform axes.
    """
    return Trajectory(np.hstack([_moving(times, x, v, a), _turning(times, orientation, spin, spin_rate)]))


def _moving(times: Array, x: Array, v: Array, a: Array) -> Array:
    """Return the columns (K - 1, 20) of time and position."""
    h = np.diff(times)[:, None]
    return np.hstack([times[:-1, None], h, quintic(h, x[:-1], x[1:] - x[:-1], v[:-1], v[1:], a[:-1], a[1:])])


def _turning(times: Array, orientation: Array, spin: Array, spin_rate: Array) -> Array:
    """Return the columns (K - 1, 22) of the attitude."""
    orientation = _on_one_side(orientation)
    h, turns = np.diff(times)[:, None], _turns(orientation)
    rate, second = rotation_vector_rates(turns, spin[1:], spin_rate[1:])
    turn = quintic(h, np.zeros_like(turns), turns, spin[:-1], rate, spin_rate[:-1], second)
    return np.hstack([turn, orientation[:-1]])


def _ends_at_rest(rates: Array | None, times: Array) -> Array:
    """Return a copy of the rates (K, 3) with zeros for NaN at both ends."""
    rows = np.full((len(times), 3), np.nan) if rates is None else np.array(rates, dtype=np.float64)
    for end in (0, -1):
        rows[end] = np.where(np.isnan(rows[end]), 0.0, rows[end])
    return rows


def _on_one_side(q: Array) -> Array:
    """Return the same attitudes (K, 4) with signs chosen for continuous quaternions."""
    flips = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0.0, -1.0, 1.0)
    return np.asarray(q * np.concatenate([[1.0], np.cumprod(flips)])[:, None])


def _turns(q: Array) -> Array:
    """Return rotation vectors (K - 1, 3), rad, from each attitude (K, 4) to the next, in the axes of the former."""
    a, b = q[:-1], q[1:]
    scalar = np.sum(a * b, axis=1, keepdims=True)
    axis = a[:, :1] * b[:, 1:] - b[:, :1] * a[:, 1:] - rotations.cross(a[:, 1:], b[:, 1:])
    return rotations.rotation_vector(np.concatenate([scalar, axis], axis=1))


def _to_body(q: Array, vectors: Array) -> Array:
    """Return vectors (K, 3), given in world axes, in the axes of the attitudes (K, 4)."""
    twice = 2.0 * rotations.cross(vectors, q[:, 1:])
    return np.asarray(vectors + q[:, :1] * twice + rotations.cross(twice, q[:, 1:]))


def quintic(h: Array, x: Array, step: Array, v0: Array, v1: Array, a0: Array, a1: Array) -> Array:
    """Return quintic coefficients (K, 18), lowest power first, in the share of the duration h (K, 1).

    The quintics lead from x (K, 3) to x + step, with the given velocities and accelerations (K, 3) at both ends.
    """
    c1, c2 = v0 * h, 0.5 * a0 * h**2
    gap = step - c1 - c2
    slope = v1 * h - c1 - 2.0 * c2
    bend = a1 * h**2 - 2.0 * c2
    c3 = 10.0 * gap - 4.0 * slope + 0.5 * bend
    c4 = -15.0 * gap + 7.0 * slope - bend
    c5 = 6.0 * gap - 3.0 * slope + 0.5 * bend
    return np.stack([x, c1, c2, c3, c4, c5], axis=2).reshape(-1, 18)
