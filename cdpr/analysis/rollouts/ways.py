"""Constants of the tables of a block, shared with `block.hpp`."""

from __future__ import annotations

# Columns of the table of operations.
WAY, OPERATION, PLACE, IN, TOGETHER = range(5)
# Kinds of operations.
IN_LANES, ALONE, MOTION, TIME, COMPLETE, NEXT, EVENTS = range(7)
# Progress of the block.
STEPS, ALIVE, LEFT = range(3)
WORD = 8  # bytes
