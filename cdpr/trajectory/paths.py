"""Standard paths from rest to rest."""

from __future__ import annotations

import math

import numpy as np

from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.trajectory.knots import join
from cdpr.trajectory.trajectory import Trajectory

# Largest deviation of a circle of quintics from the true one, as a share of the radius; round-off of the angle, a share
# of 1e-15, is added and is noticeable above 100 turns.
CIRCLE_ERROR = 1e-11


def arch(
    start: float,
    duration: float,
    ends: tuple[Array, Array],
    attitudes: tuple[Array, Array],
    height: float,
    vertical: float,
) -> Trajectory:
    """Return a pick-and-place motion: up, across and down, with continuous acceleration.

    The platform rises during the first half of the duration and sinks during the second. It moves across, and turns by
    the shortest rotation, between the shares `vertical` and 1 - `vertical` of the duration. Each is a quintic from rest
    to rest, so the arch stays within its height and is purely vertical at its ends. The arch of the thesis's program
    (cdpr3, controlsCurve) has the same phases, with `vertical` 0.213.

    Args:
        start: start time, s.
        duration: duration, s.
        ends: first and last position (3,), m, world.
        attitudes: first and last attitude (4,).
        height: height above the higher end, m.
        vertical: share of the duration, 0 <= vertical < 1/2.
    """
    share = np.unique([0.0, vertical, 0.5, 1.0 - vertical, 1.0])
    across = _rest_to_rest((share - vertical) / (1.0 - 2.0 * vertical), (1.0 - 2.0 * vertical) * duration)
    step = ends[1] - ends[0]
    x, v, a = across[:, :, None] * np.array([step[0], step[1], 0.0])
    top = max(float(ends[0][2]), float(ends[1][2])) + height
    up, down = _rest_to_rest(2.0 * share, 0.5 * duration), _rest_to_rest(2.0 * share - 1.0, 0.5 * duration)
    x[:, 2], v[:, 2], a[:, 2] = (top - ends[0][2]) * up + (ends[1][2] - top) * down
    turn = rotations.rotation_vector(rotations.multiply(rotations.conjugate(attitudes[0]), attitudes[1]))
    s, spin, spin_rate = across[:, :, None] * turn
    return join(start + duration * share, ends[0] + x, v, a, _turned(attitudes[0], s), spin, spin_rate)


def circle(
    start: float,
    duration: float,
    position: Array,
    orientation: Array,
    center: Array,
    normal: Array,
    turns: float,
    *,
    pitch: float = 0.0,
    turning: bool = False,
) -> Trajectory:
    """Return a motion around an axis; all vectors are in world axes.

    The angle is a quintic of time from rest to rest. Angle and climb are exact. The circle is met within CIRCLE_ERROR:
    the error of the quintics is at most h^6 max|x^(6)| / 46080 for segments of duration h (Hermite interpolation), and
    the sixth derivative is bounded by that of exp(i angle).

    Args:
        start: start time, s.
        duration: duration, s.
        position: (3,), first position, m.
        orientation: (4,), first attitude.
        center: (3,), point on the axis, m.
        normal: (3,), unit vector along the axis.
        turns: number of turns, right-handed if positive.
        pitch: climb along the normal, m per turn; not 0 for a helix.
        turning: True if the platform turns with the path instead of keeping its attitude.
    """
    arm = position - center
    climb = (arm @ normal) * normal
    arm = arm - climb
    side = np.cross(normal, arm)
    full = 2.0 * math.pi * turns
    count = math.ceil((_sixth_derivative(abs(full)) / (46080.0 * CIRCLE_ERROR)) ** (1.0 / 6.0))
    share = np.arange(count + 1) / count
    angle, rate, second = (full * _rest_to_rest(share, duration))[:, :, None]
    sine, cosine, lead = np.sin(angle), np.cos(angle), pitch / (2.0 * math.pi) * normal
    x = center + climb + cosine * arm + sine * side + angle * lead
    v = rate * (cosine * side - sine * arm + lead)
    a = second * (cosine * side - sine * arm + lead) - rate**2 * (cosine * arm + sine * side)
    axis = rotations.matrix(orientation).T @ normal if turning else np.zeros(3)
    return join(start + duration * share, x, v, a, _turned(orientation, angle * axis), rate * axis, second * axis)


def _rest_to_rest(share: Array, duration: float) -> Array:
    """Return rows (3, K): the quintic from 0 to 1, at rest outside, and its two time derivatives, at shares (K,)."""
    s = np.clip(share, 0.0, 1.0)
    left = 1.0 - s
    value = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    return np.array([value, 30.0 * (s * left) ** 2 / duration, 60.0 * s * left * (left - s) / duration**2])


def _turned(orientation: Array, vectors: Array) -> Array:
    """Return attitudes (K, 4): `orientation` (4,) followed by rotation vectors (K, 3) in platform axes."""
    angle = np.linalg.norm(vectors, axis=1, keepdims=True)
    turns = np.concatenate([np.cos(0.5 * angle), 0.5 * np.sinc(angle / (2.0 * math.pi)) * vectors], axis=1)
    left = np.column_stack([rotations.multiply(orientation, unit) for unit in np.eye(4)])
    return np.asarray(turns @ left.T)


def _sixth_derivative(full: float) -> float:
    """Return a bound of the sixth derivative of exp(i `full` s) by the share of time, with s the rest-to-rest quintic.

    Faa di Bruno's formula with the largest values of the first to fifth derivative of s; its sixth is zero.
    """
    s1, s2, s3, s4, s5 = 1.875, 10.0 / math.sqrt(3.0), 60.0, 360.0, 720.0
    terms = (
        10.0 * s3**2 + 15.0 * s2 * s4 + 6.0 * s1 * s5,
        15.0 * s2**3 + 60.0 * s1 * s2 * s3 + 15.0 * s1**2 * s4,
        45.0 * s1**2 * s2**2 + 20.0 * s1**3 * s3,
        15.0 * s1**4 * s2,
        s1**6,
    )
    return sum(term * full**power for power, term in enumerate(terms, 2))
