"""Times at which rows go to the log, and at which a real-time run waits."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic, sleep

from cdpr.log.recorder import BLOCK, BLOCK_SECONDS


class Pace:
    """Actions between two samples.

    `flush(k)` is called when the first k samples are complete, every 256 samples or half second of wall time. In real
    time, each sample waits for the clock, which starts at construction.

    Args:
        flush: callback, as above.
        real_time: True if samples wait.
        block: number of samples between calls, if 256 are too few for an expensive callback.

    Attributes:
        block: likewise.
        count: number of complete samples at which an action is due.
        due: time of the clock at which an action is due, s.
    """

    def __init__(self, flush: Callable[[int], None], real_time: bool = False, block: int = BLOCK) -> None:
        self.block = block
        self._flush, self._real_time = flush, real_time
        self._block, self._second = block, monotonic() + BLOCK_SECONDS
        self._started = monotonic()
        self.count, self.due = (0, 0.0) if real_time else (self._block, self._second)

    def after(self, k: int, time: float) -> None:
        """Do the actions due with k complete samples, before the one at `time` (s)."""
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
