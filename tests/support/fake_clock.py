"""Clock that only its waits and its user advance."""

from __future__ import annotations

from cdpr.simulation.clock import Clock


class FakeClock(Clock):
    """Each reading of it takes `tick` (s)."""

    def __init__(self, tick=0.0):
        self.time, self.tick = 0.0, tick

    def now(self):
        self.time += self.tick
        return self.time

    def wait(self, condition, seconds):
        self.time += max(seconds, 1e-9)  # clocks go on, also where what is left is lost in their rounding
