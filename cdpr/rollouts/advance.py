"""Numbers of the table, and of the position, of cases side by side: their meaning is in `advance.hpp`."""

from __future__ import annotations

# Columns of the table of acts.
WAY, OPERATION, PLACE, WHEN, TOGETHER = range(5)
# Ways in which an act is done.
BY_PYTHON, IN_LANES, ALONE, MOTION, COMPLETE, NEXT = range(6)
# Position of the cases.
AT_SAMPLE, AT_ACT, STOP, DUE_AT, ALIVE, LEFT = range(6)
# Words of an array of one case: its address, its size, and its first row in the block.
ADDRESS, SIZE, FIRST = range(3)
WORD = 8  # bytes
