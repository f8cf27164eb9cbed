"""Times at which rows go to the log."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

from cdpr.log.blocks import BLOCK, BLOCK_SECONDS


class Pace:
    """Actions between two samples.

    `flush(k)` is called when the first k samples are complete, every 256 samples or half second of wall time.

    Args:
        flush: callback, as above.
        block: number of samples between calls, if 256 are too few for an expensive callback.

    Attributes:
        block: likewise.
        count: number of complete samples at which an action is due.
        due: time of the clock at which an action is due, s.
    """

    def __init__(self, flush: Callable[[int], None], block: int = BLOCK) -> None:
        self.block, self.count = block, block
        self._flush = flush
        self.due = monotonic() + BLOCK_SECONDS

    def after(self, k: int) -> None:
        """Do the actions due with k complete samples."""
        if k >= self.count or monotonic() > self.due:
            self._flush(k)
            self.count, self.due = k - k % self.block + self.block, monotonic() + BLOCK_SECONDS
