"""Change of a motion's target with continuous position, velocity and acceleration."""

from __future__ import annotations

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.trajectory.jerk_limited import NO_MOVE, Limits
from cdpr.trajectory.knots import Knot, through
from cdpr.trajectory.trajectory import Stopping, Trajectory, sample_segments

# Sampling points for a quintic's largest norms. Between them, the norm of a polynomial of degree n exceeds the samples
# by about (n / places)^2 of itself, and finite differences of third derivatives have the same error: below MISSED.
PLACES = 500
MISSED = 1e-4

# Tried durations (s) with their ratio, followed by bisection to the relative precision PRECISE.
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
    """Return `motion` until `time` (s), followed by one quintic to a pose at rest.

    Args:
        motion: previous motion; not one that slows down to rest.
        time: time of the change, s.
        position: (3,) target, m, world; None for the position at `time`.
        orientation: (4,) target attitude, a unit quaternion; None likewise. The shorter rotation is taken.
        duration: duration, s; None if limits are given.
        limits: limits of the translation; the quintic is the shortest that respects them.
        angular: limits of the rotation, required if it changes.

    Raises:
        CdprError: if no quintic respects the limits, such as if the motion is already faster.
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
    """Return the move from a sample (19,) of a motion to a knot."""
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
    """Return the shortest duration (s) of a move within limits: the first one found among those tried."""

    def kept(duration: float) -> bool:
        return _share(_move(here, there, 0.0, duration), limits, angular) <= 1.0

    too_short, duration = 0.0, SHORTEST
    while not kept(duration):
        too_short, duration = duration, FACTOR * duration
        if duration > LONGEST:
            speed, turn = np.linalg.norm(here[7:10]), np.linalg.norm(here[10:13])
            spins = "" if angular is None else f" and {turn:.4g} rad/s"
            raise CdprError(
                f"no quintic satisfies these limits, starting at {speed:.4g} m/s{spins}: raise them, give duration "
                "instead, or wait until the motion rests"
            )
    while duration - too_short > PRECISE * duration:
        middle = 0.5 * (too_short + duration)
        too_short, duration = (too_short, middle) if kept(middle) else (middle, duration)
    return duration


def _share(move: Trajectory, limits: Limits, angular: Limits | None) -> float:
    """Return the largest ratio of a move's derivatives to the limits; the move is one segment from time 0 on."""
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
