"""Desired motions made of segments, in each of which position and rotation vector are quintics of time.

Attitude: R(t) = R_0 exp(phi(t)) with a quintic rotation vector phi in the axes of the segment's beginning.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from cdpr.errors import CdprError
from cdpr.model.arrays import checked, live
from cdpr.model.robot import Array

# Columns of a segment: start, duration, coefficients of position and of the rotation vector (3 x 6 each, lowest power
# first, of the share of the duration), attitude at its beginning.
COLUMNS = 42


class Trajectory:
    """A desired motion: piecewise quintic, at rest before its start and after its end.

    `segments` are (K, 42), as `COLUMNS` says. Raises CdprError where they are not.
    """

    def __init__(self, segments: Array) -> None:
        self.segments = checked(np.atleast_2d(segments), (None, COLUMNS), "segments").copy()
        if not len(self.segments):
            raise CdprError("segments: a motion has at least one")

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

        return partial(sample, self.segments, live(desired, (19,), "desired"))

    def sample(self, time: float) -> Array:
        """Return the desired state and accelerations at `time` (s), (19,), laid out as `cdpr.model` says."""
        desired = np.empty(19)
        self.sampler(desired)(time)
        return desired


class Stopping(Trajectory):
    """A motion that is slowed down to rest along its path, from `begin` on within `duration` (s)."""

    def __init__(self, motion: Trajectory, begin: float, duration: float) -> None:
        super().__init__(motion.segments)
        self.begin = begin
        self.duration = duration

    @property
    def end(self) -> float:
        """When the motion rests, s."""
        return min(super().end, self.begin + self.duration)

    def sampler(self, desired: Array) -> Callable[[float], None]:
        """Return the function that writes the sample at a time (s) into `desired` (19,)."""
        from cdpr.trajectory.kernels import sample_stopping

        return partial(sample_stopping, self.segments, self.begin, self.duration, live(desired, (19,), "desired"))


def hold(position: Array, orientation: Array) -> Trajectory:
    """Stay at a pose."""
    segment = np.zeros(COLUMNS)
    segment[1] = 1.0
    segment[2:20:6] = position
    segment[38:] = orientation
    return Trajectory(segment)
