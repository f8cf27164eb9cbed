"""Parallel threads over many rows, for compiled code that releases the GIL."""

from __future__ import annotations

import os
from collections.abc import Callable

CHUNK = 2048  # rows per thread and task: some milliseconds


def in_threads(count: int, part: Callable[[slice], None], jobs: int | None = None, chunk: int = CHUNK) -> None:
    """Process `count` rows in parts that do not depend on the number of threads; by default one thread per core."""
    cuts = [slice(start, start + chunk) for start in range(0, count, chunk)]
    threads = len(os.sched_getaffinity(0)) if jobs is None else jobs
    if threads == 1 or len(cuts) < 2:
        for cut in cuts:
            part(cut)
        return
    from concurrent.futures import ThreadPoolExecutor  # slow to import, and not needed for few rows

    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(part, cuts):
            pass
