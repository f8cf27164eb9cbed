"""Parallel jobs in threads, for compiled code that releases the GIL."""

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
    """Run jobs in threads, and call `done` in this thread with each result as it is ready.

    Args:
        jobs: the jobs.
        run: function of a job and of a callable that returns True after cancellation, upon which it should return soon.
        threads: number of threads.
        done: called with each result.
        name: prefix of the threads' names.
    """
    stop = threading.Event()
    with ThreadPoolExecutor(threads, thread_name_prefix=name) as pool:
        try:
            running: set[Future[R]] = set()
            while True:
                # One job more than threads: no thread idles, and few results are in memory.
                running |= {pool.submit(run, job, stop.is_set) for job in islice(jobs, threads + 1 - len(running))}
                if not running:
                    return
                ended, running = wait(running, return_when=FIRST_COMPLETED)
                for each in ended:
                    done(each.result())
        finally:
            stop.set()
            pool.shutdown(wait=False, cancel_futures=True)
