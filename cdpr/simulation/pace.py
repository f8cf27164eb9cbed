"""When rows go to the log, and when a run in real time waits."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic, sleep

from cdpr.log.recorder import BLOCK, BLOCK_SECONDS


class Pace:
    """What comes between two samples.

    `flush(k)` is called when the first k samples are complete, every 256 of them or half second of wall time. In real
    time each sample waits for the clock, which starts now.

    Args:
        flush: as said.
        real_time: whether samples wait.
        block: so many samples, where 256 are too few: what looks at them takes its time.

    Attributes:
        block: likewise.
        count: with so many samples complete something is due.
        due: likewise, at this time of the clock, s.
    """

    def __init__(self, flush: Callable[[int], None], real_time: bool = False, block: int = BLOCK) -> None:
        self.block = block
        self._flush, self._real_time = flush, real_time
        self._block, self._second = block, monotonic() + BLOCK_SECONDS
        self._started = monotonic()
        self.count, self.due = (0, 0.0) if real_time else (self._block, self._second)

    def after(self, k: int, time: float) -> None:
        """Do what is due with k samples complete, before the one at `time` (s)."""
        if k >= self._block or monotonic() > self._second:
            self._flush(k)
            self._block, self._second = k - k % self.block + self.block, monotonic() + BLOCK_SECONDS
        while self._real_time and (ahead := time - (monotonic() - self._started)) > 0.0:
            if monotonic() > self._second:
                self._flush(k)
                self._second = monotonic() + BLOCK_SECONDS
            sleep(min(ahead, BLOCK_SECONDS))
        if not self._real_time:
            self.count, self.due = self._block, self._second
