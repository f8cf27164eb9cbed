"""Desired motions made of quintic segments between knots.

Position: each coordinate is the quintic that meets position, velocity and acceleration at both ends of a segment. (The
thesis's equations 6.19 to 6.21 for the same polynomial are misprinted; these were derived anew.)

Attitude: R(t) = R_0 exp(phi(t)) with a quintic rotation vector phi in the axes of the segment's first knot. Between
knots at rest phi keeps its direction, so the platform takes the shortest rotation.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.trajectory.spline import minimum_jerk

# Columns of a segment: start, duration, coefficients of position and of the rotation vector (3 x 6 each, lowest power
# first, of the share of the duration), attitude of the first knot.
COLUMNS = 42


@dataclass(frozen=True, eq=False)
class Knot:
    """Where the platform should be at a time, and how fast; world axes.

    Velocities and accelerations that are None are chosen: zero at the first and last knot, minimum-jerk in between.
    """

    time: float  # s
    position: Array  # (3,), m
    orientation: Array  # (4,) quaternion w, x, y, z
    velocity: Array | None = None  # (3,), m/s
    angular_velocity: Array | None = None  # (3,), rad/s
    acceleration: Array | None = None  # (3,), m/s^2
    angular_acceleration: Array | None = None  # (3,), rad/s^2


class Trajectory:
    """A desired motion: piecewise quintic, at rest before its start and after its end."""

    def __init__(self, segments: Array) -> None:
        self.segments = np.ascontiguousarray(segments, dtype=np.float64).reshape(-1, COLUMNS)

    @property
    def start(self) -> float:
        """When the motion begins, s."""
        return float(self.segments[0, 0])

    @property
    def end(self) -> float:
        """When the motion ends, s."""
        return float(self.segments[-1, 0] + self.segments[-1, 1])

    def sampler(self, desired: Array) -> Callable[[float], None]:
        """Return the function that writes the sample at a time (s) into `desired` (19,)."""
        from cdpr.trajectory.kernels import sample

        return partial(sample, self.segments, desired)

    def sample(self, time: float) -> Array:
        """Return the desired state and accelerations at `time` (s), (19,), laid out as `cdpr.model` says."""
        desired = np.empty(19)
        self.sampler(desired)(time)
        return desired


def hold(position: Array, orientation: Array) -> Trajectory:
    """Stay at a pose."""
    segment = np.zeros(COLUMNS)
    segment[1] = 1.0
    segment[2:20:6] = position
    segment[38:] = orientation
    return Trajectory(segment)


def through(knots: Sequence[Knot]) -> Trajectory:
    """Pass through two or more knots with increasing times, with continuous acceleration."""
    times = np.array([knot.time for knot in knots])
    if len(knots) < 2 or not np.all(np.diff(times) > 0.0):
        raise ValueError("a motion needs two or more knots with increasing times")
    velocity, acceleration = minimum_jerk(
        times,
        np.array([knot.position for knot in knots]),
        _known([knot.velocity for knot in knots]),
        _known([knot.acceleration for knot in knots]),
    )
    attitudes = [np.array(knot.orientation, dtype=np.float64) for knot in knots]
    for before, after in pairwise(attitudes):
        if before @ after < 0.0:  # q and -q are one attitude: stay on one side, so that the quaternion does not jump
            after *= -1.0
    turns = [rotations.rotation_vector(rotations.multiply(rotations.conjugate(a), b)) for a, b in pairwise(attitudes)]
    # In platform axes, where a turn keeps its rotation vector, the sum of the turns is smoothed like a position.
    to_body = [rotations.matrix(q).T for q in attitudes]
    spin, spin_rate = minimum_jerk(
        times,
        np.concatenate([np.zeros((1, 3)), np.cumsum(turns, axis=0)]),
        _known([_turned(R, knot.angular_velocity) for R, knot in zip(to_body, knots, strict=True)]),
        _known([_turned(R, knot.angular_acceleration) for R, knot in zip(to_body, knots, strict=True)]),
    )
    segments = np.empty((len(turns), COLUMNS))
    for k, turn in enumerate(turns):
        duration = times[k + 1] - times[k]
        ends = slice(k, k + 2)
        points = np.array([knots[k].position, knots[k + 1].position])
        rates = np.array([spin[k], *_rotation_vector_rates(turn, spin[k + 1], spin_rate[k + 1])])
        segments[k, :2] = times[k], duration
        segments[k, 2:20] = _quintic(duration, points, velocity[ends], acceleration[ends]).ravel()
        segments[k, 20:38] = _quintic(
            duration, np.array([np.zeros(3), turn]), rates[:2], np.array([spin_rate[k], rates[2]])
        ).ravel()
        segments[k, 38:] = attitudes[k]
    return Trajectory(segments)


def _known(values: list[Array | None]) -> Array:
    """Rows of given values; NaN where one is to be chosen, zero at the ends."""
    rows = np.full((len(values), 3), np.nan)
    rows[0] = rows[-1] = 0.0
    for row, value in zip(rows, values, strict=True):
        if value is not None:
            row[:] = value
    return rows


def _turned(R: Array, value: Array | None) -> Array | None:
    return None if value is None else np.asarray(R @ value)


def _quintic(duration: float, x: Array, v: Array, a: Array) -> Array:
    """Coefficients (3, 6), lowest power first, of the share of the duration.

    x, v, a are (2, 3): position, velocity and acceleration at both ends.
    """
    c0, c1, c2 = x[0], v[0] * duration, 0.5 * a[0] * duration**2
    gap = x[1] - c0 - c1 - c2
    slope = v[1] * duration - c1 - 2.0 * c2
    bend = a[1] * duration**2 - 2.0 * c2
    c3 = 10.0 * gap - 4.0 * slope + 0.5 * bend
    c4 = -15.0 * gap + 7.0 * slope - bend
    c5 = 6.0 * gap - 3.0 * slope + 0.5 * bend
    return np.stack([c0, c1, c2, c3, c4, c5], axis=1)


def _rotation_vector_rates(phi: Array, omega: Array, alpha: Array) -> tuple[Array, Array]:
    """First and second derivative of a rotation vector for body rates omega and alpha.

    From omega = J(phi) phi' and alpha = J phi'' + J' phi', J the right Jacobian of SO(3).
    """
    from cdpr.trajectory.kernels import body_rates

    def rates(first: Array, second: Array) -> Array:
        vectors = [(float(v[0]), float(v[1]), float(v[2])) for v in (phi, first, second)]
        return np.array(body_rates(*vectors), dtype=np.float64)

    # (omega, alpha) is linear in phi' and, given phi', alpha is phi'' mapped by J plus a part free of phi''.
    zero = np.zeros(3)
    jacobian = np.column_stack([rates(unit, zero)[0] for unit in np.eye(3)])
    first = np.linalg.solve(jacobian, omega)
    second = np.linalg.solve(jacobian, alpha - rates(first, zero)[1])
    return first, second
