"""Memory for tables that are filled row by row: in huge pages where the system has them.

The system hands memory out when it is first touched, and to do that for every 4 KiB costs a sixth of a step on
`reference`; for every 2 MiB it costs nothing to speak of. What is not touched costs nothing either way.
"""

from __future__ import annotations

import mmap

import numpy as np

from cdpr.model.robot import Array

HUGE = 2**21  # bytes: a huge page of x86-64, and of the other machines with pages of 4 KiB


def table(rows: int, width: int) -> Array:
    """Return (rows, width), whatever is in it. Raises MemoryError."""
    size = 8 * rows * width
    advice, private = getattr(mmap, "MADV_HUGEPAGE", None), getattr(mmap, "MAP_PRIVATE", None)
    if size < HUGE or advice is None or private is None:
        return np.empty((rows, width))
    try:
        memory = mmap.mmap(-1, -(-size // HUGE) * HUGE + HUGE, flags=private | mmap.MAP_ANONYMOUS)
        memory.madvise(advice)
    except (OSError, OverflowError):  # a system without them, or one that is asked for more than it has
        return np.empty((rows, width))
    start = -np.frombuffer(memory, np.uint8).ctypes.data % HUGE
    return np.frombuffer(memory, np.float64, rows * width, start).reshape(rows, width)
