"""Many rows in threads that compiled code lets run side by side."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

CHUNK = 2048  # rows that a thread takes at a time: some milliseconds


def in_threads(count: int, part: Callable[[slice], None], jobs: int | None = None, chunk: int = CHUNK) -> None:
    """Do `count` rows in parts, which are the same however many threads there are: one for each core unless given."""
    cuts = [slice(start, start + chunk) for start in range(0, count, chunk)]
    threads = len(os.sched_getaffinity(0)) if jobs is None else jobs
    if threads == 1 or len(cuts) < 2:
        for cut in cuts:
            part(cut)
        return
    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(part, cuts):
            pass
