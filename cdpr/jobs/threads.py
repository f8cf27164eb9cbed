"""Jobs of any kind in threads, which compiled code lets run side by side."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice
from typing import TypeVar

J = TypeVar("J")
R = TypeVar("R")


def beside(
    jobs: Iterator[J],
    run: Callable[[J, Callable[[], bool]], R],
    threads: int,
    done: Callable[[R], None],
    name: str,
) -> None:
    """Run jobs in so many threads, and call `done` here with what each gave, as it ends.

    `run` also gets what tells it that nobody waits for it any more: it should end soon then, however it does.
    """
    stop = threading.Event()
    with ThreadPoolExecutor(threads, thread_name_prefix=name) as pool:
        try:
            running: set[Future[R]] = set()
            while True:
                # One more than there are threads: none waits for this one, and few results are in memory.
                running |= {pool.submit(run, job, stop.is_set) for job in islice(jobs, threads + 1 - len(running))}
                if not running:
                    return
                ended, running = wait(running, return_when=FIRST_COMPLETED)
                for each in ended:
                    done(each.result())
        finally:
            stop.set()
            pool.shutdown(wait=False, cancel_futures=True)
