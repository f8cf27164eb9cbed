"""Clock of a running simulation, and the simulated time that is due by it."""

from __future__ import annotations

import math
from threading import Condition
from time import monotonic
from typing import Any

from cdpr.base.errors import CdprError
from cdpr.base.problems import shown

SPEEDS = 0.001, 1e6  # multiples of real time
LATE = 0.5  # s of delay after which the simulation no longer tries to catch up
ROUNDING = 1e-6  # slices


class Clock:
    """Monotonic clock; tests replace it by one that waits without delay."""

    def now(self) -> float:
        """Return the time, s."""
        return monotonic()

    def wait(self, condition: Condition, seconds: float) -> None:
        """Wait until the condition, whose lock is held, is notified, or for this time."""
        condition.wait(seconds)


def next_portion(steps: int, seconds: float, limit: float, most: int) -> int:
    """Return the number of steps of the next call: doubled if the last was short, halved if too long, else unchanged.

    Args:
        steps: number of steps of the last call.
        seconds: duration of the last call, s.
        limit: longest desired duration, s; calls of at least half of it keep their size.
        most: largest number of steps.
    """
    if seconds > limit:
        return max(steps // 2, 1)
    return min(2 * steps, most) if seconds < 0.5 * limit else steps


class Pacing:
    """Simulated time that is due by a clock, in slices.

    Args:
        clock: clock to follow.
        speed: simulated time over time of the clock; None for no limit.

    Attributes:
        speed: likewise.
        slice: simulated time that becomes due at once, s.
    """

    def __init__(self, clock: Clock, speed: float | None = 1.0) -> None:
        self._clock, self.speed, self.slice = clock, speed, 1.0
        self.start(0.0)

    def start(self, time: float) -> None:
        """Start at a simulated time, s."""
        self._wall, self._time = self._clock.now(), time
        self._then, self._factor = (self._wall, time), self.speed

    def change(self, speed: float | None, time: float) -> None:
        """Change the speed at a simulated time, s; repeated changes do not delay the next slice."""
        due = time if self.speed is None else self._time + self.speed * (self._clock.now() - self._wall)
        self.speed = speed
        self.start(time)
        self._time = due

    def when(self, time: float) -> float:
        """Return the time of the clock at which the slice after a simulated time is due, s."""
        return -math.inf if self.speed is None else self._wall + (time + self.slice - self._time) / self.speed

    def slices(self, time: float) -> int | None:
        """Return the number of slices that are due after a simulated time; None for no limit."""
        if self.speed is None:
            return None
        now = self._clock.now()
        if now - self.when(time) > LATE:  # too slow, or suspended: continue without catching up
            self._wall, self._time = now, time + self.slice
        behind = self._time + self.speed * (now - self._wall) - time
        return max(0, int(behind / self.slice + ROUNDING))

    def factor(self, time: float) -> float | None:
        """Return the real-time factor of about the last second."""
        (then, before), now = self._then, self._clock.now()
        if now - then >= 1.0:
            self._factor, self._then = (time - before) / (now - then), (now, time)
        return None if self._factor is None else round(self._factor, 4)


def checked_speed(speed: Any) -> float | None:
    """Return a speed.

    Raises:
        CdprError: if it is not a number within `SPEEDS`.
    """
    least, most = SPEEDS
    number = isinstance(speed, int | float) and not isinstance(speed, bool)
    if speed is not None and not (number and least <= speed <= most):
        raise CdprError(f"speed: expected a number from {least:g} to {most:g}, got {shown(speed)}")
    return None if speed is None else float(speed)
