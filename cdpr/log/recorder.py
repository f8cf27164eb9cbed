"""Keeps the rows of a run, in memory and on disk."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cdpr.log.mcap_file import BLOCK
from cdpr.log.run import Header
from cdpr.log.writer import LogWriter
from cdpr.model.robot import Array

__all__ = ["BLOCK", "LOG_NAME", "Recorder"]

LOG_NAME = "log.mcap"


class Recorder:
    """Rows of a run of `steps` steps, and their log where a run folder is given.

    The loop fills `rows[k]` itself, one copy a step; the time in it is k * control_step. With n rows done, it
    calls `flush(n)` when `n % BLOCK == 0`, which is cheapest, and when half a second has passed since it last
    did; and `close(n)` at the end. Without a folder there is nothing to write, and both only return.

    Raises OutputError where the log cannot be written; the rows in memory are not touched by that.
    """

    def __init__(self, header: Header, steps: int, folder: Path | None = None) -> None:
        self.rows: Array = np.empty((steps + 1, header.layout.width))  # (steps + 1, width)
        self._writer = None if folder is None else LogWriter(folder / LOG_NAME, header)

    def flush(self, stop: int) -> None:
        """Bring the log up to row `stop`, excluded."""
        if self._writer is not None:
            self._writer.write(self.rows, stop)

    def close(self, stop: int) -> Array:
        """Complete the log with the rows up to `stop`, excluded, and return these rows."""
        if self._writer is not None:
            self._writer.close(self.rows, stop)
        return self.rows[:stop]
