"""Desired motions of segments with quintic position and rotation vector.

Attitude: R(t) = R_0 exp(phi(t)) with a quintic rotation vector phi in the axes of the segment's beginning.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.errors import CdprError
from cdpr.model.arrays import checked, live
from cdpr.model.robot import Array
from cdpr.native.arrays import reals, whole
from cdpr.native.bind import bind

# Columns of a segment: start, duration, coefficients of position and of the rotation vector (3 x 6 each, lowest power
# first, in the share of the duration), attitude at its beginning.
COLUMNS = 42


class Trajectory:
    """Desired motion: piecewise quintic, at rest before its start and after its end.

    Args:
        segments: (K, 42), see `COLUMNS`.

    Raises:
        CdprError: if the segments are invalid.
    """

    def __init__(self, segments: Array) -> None:
        self.segments = checked(np.atleast_2d(segments), (None, COLUMNS), "segments").copy()
        if not len(self.segments):
            raise CdprError("segments: a motion has at least one")
        self._sampling: tuple[Array, Callable[[float], object], Lock] | None = None  # bound at the first sample

    @property
    def start(self) -> float:
        """Start time, s."""
        return float(self.segments[0, 0])

    @property
    def end(self) -> float:
        """End time, s."""
        return float(self.segments[-1, 0] + self.segments[-1, 1])

    def sampler(self, desired: Array) -> Callable[[float], object]:
        """Return the function that writes the sample at a time (s) into `desired` (19,)."""
        return bind("desired_motion", segments=self.segments, desired=live(desired, (19,), "desired"))

    def sample(self, time: float) -> Array:
        """Return the desired state and accelerations at `time` (s), (19,), in the layout of `cdpr.model`."""
        if self._sampling is None:
            desired = np.empty(19)
            self._sampling = desired, self.sampler(desired), Lock()
        desired, write, lock = self._sampling
        with lock:
            write(time)
            return desired.copy()

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_sampling": None}


class Stopping(Trajectory):
    """Motion that slows down to rest along its path, from `begin` within `duration` (s)."""

    def __init__(self, motion: Trajectory, begin: float, duration: float) -> None:
        super().__init__(motion.segments)
        self.begin = begin
        self.duration = duration

    @property
    def end(self) -> float:
        """Time of rest, s."""
        return min(super().end, self.begin + self.duration)

    def sampler(self, desired: Array) -> Callable[[float], object]:
        """Return the function that writes the sample at a time (s) into `desired` (19,)."""
        written = live(desired, (19,), "desired")
        stop = {"begin": self.begin, "duration": self.duration}
        return bind("stopping_motion", segments=self.segments, desired=written, **stop)


def sample_segments(segments: ArrayLike, which: ArrayLike, times: ArrayLike) -> Array:
    """Return samples of segments, each at its own time.

    Args:
        segments: (N, 42), see `COLUMNS`.
        which: (K,) rows of `segments`.
        times: (K,) s.

    Returns:
        (K, 19), in the layout of `cdpr.model`; at rest before and after the segment.

    Raises:
        ValueError: if the shapes do not match, or a row does not exist.
    """
    rows = whole(which, "which")
    arrays = reals(segments=segments, times=times)
    if rows.size and not 0 <= rows.min() <= rows.max() < len(arrays["segments"]):
        raise ValueError(f"segment_samples: which: expected rows 0 to {len(arrays['segments']) - 1}, got {rows}.")
    desired = np.empty((rows.size, 19))
    bind("segment_samples", **arrays, which=rows, desired=desired)()
    return desired


def hold(position: Array, orientation: Array) -> Trajectory:
    """Return a motion at rest at a pose."""
    segment = np.zeros(COLUMNS)
    segment[1] = 1.0
    segment[2:20:6] = position
    segment[38:] = orientation
    return Trajectory(segment)
