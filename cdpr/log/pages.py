"""Memory of large tables that are filled row by row, in huge pages if available.

The system allocates memory at the first access. With pages of 4 KiB this takes a sixth of a step on `reference`; with 2
MiB it is negligible. Unused memory costs nothing.
"""

from __future__ import annotations

import mmap

import numpy as np

from cdpr.model.robot import Array

HUGE = 2**21  # bytes: huge page of x86-64 and other machines with 4 KiB pages


def table(rows: int, width: int) -> Array:
    """Return an uninitialised table (rows, width).

    Raises:
        MemoryError: if it is too large.
    """
    size = 8 * rows * width
    advice, private = getattr(mmap, "MADV_HUGEPAGE", None), getattr(mmap, "MAP_PRIVATE", None)
    if size < HUGE or advice is None or private is None:
        return np.empty((rows, width))
    try:
        memory = mmap.mmap(-1, -(-size // HUGE) * HUGE + HUGE, flags=private | mmap.MAP_ANONYMOUS)
        memory.madvise(advice)
    except (OSError, OverflowError):  # unsupported, or more than available
        return np.empty((rows, width))
    start = -np.frombuffer(memory, np.uint8).ctypes.data % HUGE
    return np.frombuffer(memory, np.float64, rows * width, start).reshape(rows, width)
