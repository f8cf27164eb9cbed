"""Leaving a motion for another pose, without a jump in position, velocity or acceleration."""

from __future__ import annotations

import numpy as np

from cdpr.errors import CdprError
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.trajectory.jerk_limited import NO_MOVE, Limits
from cdpr.trajectory.knots import Knot, through
from cdpr.trajectory.trajectory import Stopping, Trajectory, sample_segments

# A quintic's largest norms are looked for at so many places. Between two of them a norm of polynomials of degree n
# exceeds both by about (n / places)^2 of itself, and so wrong are third derivatives taken by differences: below MISSED.
PLACES = 500
MISSED = 1e-4

# Durations (s) that are tried; from one to the next by this factor, then halved until it is met within PRECISE.
SHORTEST, LONGEST, FACTOR, PRECISE = 1e-3, 1e4, 1.2, 1e-6


def redirected(
    motion: Trajectory,
    time: float,
    position: Array | None,
    orientation: Array | None,
    duration: float | None,
    limits: Limits | None = None,
    angular: Limits | None = None,
) -> Trajectory:
    """Return `motion` until `time` (s), and from then on one quintic to a pose, at rest there.

    Args:
        motion: as before; not one that is slowed down to rest.
        time: when to leave it.
        position: (3,) where to go, m, world; None for where the motion is at `time`.
        orientation: (4,) attitude there, a unit quaternion; None likewise. The shorter way round is taken.
        duration: how long it takes, s; None where limits are given.
        limits: largest norms of the translation's derivatives: the quintic is the shortest that keeps them.
        angular: those of the rotation, which needs them where it turns.

    Raises CdprError where no quintic keeps the limits, as where the motion is faster already.
    """
    if isinstance(motion, Stopping):
        raise CdprError(f"the motion stops at {motion.begin:g} s, and cannot go elsewhere")
    here = motion.sample(time)
    there = Knot(
        time,
        here[:3] if position is None else position,
        here[3:7] if orientation is None else orientation,
        *np.zeros((4, 3)),
    )
    if duration is None:
        assert limits is not None
        turns = rotations.rotation_vector(rotations.multiply(rotations.conjugate(here[3:7]), there.orientation))
        if angular is None and max(*np.abs(turns), *np.abs(here[10:13]), *np.abs(here[16:])) > NO_MOVE:
            raise CdprError("angular_limits are required, for the attitude changes on the way")
        duration = _shortest(here, there, limits, angular)
    row = _move(here, there, time, duration)
    before = motion.segments[motion.segments[:, 0] < time]
    return Trajectory(np.concatenate([before, row.segments]))


def _move(here: Array, there: Knot, time: float, duration: float) -> Trajectory:
    """Go from a sample (19,) of a motion to a knot."""
    start = Knot(time, here[:3], here[3:7], here[7:10], here[10:13], here[13:16], here[16:])
    end = Knot(
        time + duration,
        there.position,
        there.orientation,
        there.velocity,
        there.angular_velocity,
        there.acceleration,
        there.angular_acceleration,
    )
    return through([start, end])


def _shortest(here: Array, there: Knot, limits: Limits, angular: Limits | None) -> float:
    """Return the shortest duration (s) of a move within limits: the first that is found of those tried."""

    def kept(duration: float) -> bool:
        return _share(_move(here, there, 0.0, duration), limits, angular) <= 1.0

    too_short, duration = 0.0, SHORTEST
    while not kept(duration):
        too_short, duration = duration, FACTOR * duration
        if duration > LONGEST:
            speed, turn = np.linalg.norm(here[7:10]), np.linalg.norm(here[10:13])
            spins = "" if angular is None else f" and {turn:.4g} rad/s"
            raise CdprError(
                f"no quintic keeps these limits from where the motion is then, at {speed:.4g} m/s{spins}: "
                "raise them, say duration instead, or wait until it rests"
            )
    while duration - too_short > PRECISE * duration:
        middle = 0.5 * (too_short + duration)
        too_short, duration = (too_short, middle) if kept(middle) else (middle, duration)
    return duration


def _share(move: Trajectory, limits: Limits, angular: Limits | None) -> float:
    """Return how much of the limits a move of one segment, which begins at time 0, takes."""
    times = np.linspace(0.0, move.end, PLACES + 1)
    values = sample_segments(move.segments, np.zeros(len(times), dtype=np.int64), times)
    shares = [0.0]
    for bound, first in ((limits, 7), (angular, 10)):
        if bound is not None:
            rate, second = values[:, first : first + 3], values[:, first + 6 : first + 9]
            third = np.gradient(second, times[1], axis=0, edge_order=2)
            for derivative, limit in ((rate, bound.velocity), (second, bound.acceleration), (third, bound.jerk)):
                shares.append(float(np.linalg.norm(derivative, axis=1).max()) / limit)
    return (1.0 + MISSED) * max(shares)
