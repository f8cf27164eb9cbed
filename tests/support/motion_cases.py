"""Samples of motions, and their continuity."""

from __future__ import annotations

import numpy as np

UPRIGHT = np.array([1.0, 0, 0, 0])


def samples(trajectory, count=2001):
    times = np.linspace(trajectory.start, trajectory.end, count)
    return times, np.array([trajectory.sample(time) for time in times])


def assert_smooth(trajectory):
    """Position, velocity and acceleration are continuous where segments meet, and zero rates at both ends."""
    ends = trajectory.segments[1:, 0]
    for time in ends[:: max(len(ends) // 40, 1)]:
        before, after = trajectory.sample(time - 1e-10), trajectory.sample(time + 1e-10)
        np.testing.assert_allclose(before, after, atol=1e-6)
    for time in (trajectory.start, trajectory.end):
        np.testing.assert_allclose(trajectory.sample(time)[7:], 0.0, atol=1e-8)
