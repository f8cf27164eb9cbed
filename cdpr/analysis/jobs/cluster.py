"""Execution on a Dask cluster: general jobs, and cases, each in its own process next to the cluster's worker."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from cdpr.analysis.jobs.folder import clear
from cdpr.analysis.jobs.pool import TICK, Case, Executor, Outcome, ready, wait
from cdpr.base.errors import CdprError, ExitCode, PluginError, one_line

CONNECTING = 20  # s, time limit for finding the scheduler

GONE = "lost the connection to the scheduler at {}; finished cases are kept"

NOISY = ("distributed", "tornado")  # their tracebacks are replaced by messages of this module

J = TypeVar("J")
R = TypeVar("R")

_mine = threading.local()  # one worker process per thread of a cluster worker, reused between cases


def executor(address: str) -> Executor:
    """Return an executor for cases on the cluster with its scheduler at `address`, such as tcp://host:8786.

    Raises:
        PluginError: if distributed is not installed.
        CdprError: if no scheduler answers.
    """
    check_installed()

    def execute(cases: Sequence[Case], *, timeout: float | None, done: Callable[[Outcome], None]) -> None:
        def end(key: str, outcome: Outcome | None, lost: str) -> None:
            done(outcome or Outcome(key, "died", lost, "", code=ExitCode.BACKEND_DIED))

        spread(address, partial(run_here, timeout=timeout), {case.key: case for case in cases}, end)

    return execute


def check_installed() -> None:
    """Raise PluginError if distributed is not installed."""
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        raise PluginError("a cluster needs distributed, which is not installed: pip install 'cdpr[cluster]'") from error


def spread(
    address: str,
    run: Callable[[J], R | None],
    jobs: Mapping[str, J],
    done: Callable[[str, R | None, str], None],
    ahead: int | None = None,
) -> None:
    """Run jobs on a cluster and report each one as it ends.

    Args:
        address: address of the scheduler.
        run: function that runs one job.
        jobs: jobs by key.
        done: called with the key, the result of `run`, and the reason if the job was lost.
        ahead: number of jobs to submit per thread of the cluster; all at once by default. It limits the results in the
            cluster's memory.

    Raises:
        PluginError: if distributed is not installed.
        CdprError: if no scheduler answers, or the connection is lost.
    """
    check_installed()
    import distributed

    if not jobs:
        return
    for name in [name for name in logging.root.manager.loggerDict if name.partition(".")[0] in NOISY]:
        logging.getLogger(name).setLevel(logging.CRITICAL)  # distributed's configuration sets levels per logger
    try:
        client = distributed.Client(address, timeout=CONNECTING)
    except (OSError, ValueError, TypeError) as error:  # TypeError: tls:// without certificates
        raise CdprError(f"--scheduler {address}: no Dask scheduler answers there: {one_line(error)}") from error
    with client:  # closing it cancels all jobs: see `run_here`
        try:
            waiting = iter(jobs.items())
            futures = {client.submit(run, job, pure=False): key for key, job in islice(waiting, _room(client, ahead))}
            completed = distributed.as_completed(futures)
            for future in completed:
                try:
                    fault = future.exception()
                    result = future.result() if fault is None else None
                except OSError as error:  # the connection broke, and the client has not noticed yet
                    raise _Lost(GONE.format(address)) from error
                lost = "" if fault is None else f"lost by the cluster: {one_line(fault)}"
                done(futures.pop(future), result, lost)
                future.release()  # its result may be large
                for key, job in islice(waiting, _room(client, ahead, len(futures))):
                    futures[added := client.submit(run, job, pure=False)] = key
                    completed.add(added)
        except CdprError:
            raise
        except Exception as error:
            if client.status == "running":
                raise
            raise _Lost(GONE.format(address)) from error


def _room(client: Any, ahead: int | None, has: int = 0) -> int | None:
    """Return the number of jobs that may be added; the number of workers may change at any time."""
    return None if ahead is None else max(0, ahead * max(1, sum(client.nthreads().values())) - has)


class _Lost(CdprError):  # noqa: N818 - as SimulationStopped
    exit_code = ExitCode.BACKEND_DIED


def run_here(case: Case, timeout: float | None) -> Outcome | None:
    """Run a case in the worker process of this thread; return None if it was cancelled."""
    from distributed import get_worker

    here = get_worker()
    task = here.get_current_task()
    if case.out is not None:
        clear(Path(case.out))  # the cluster repeats a case if its machine was lost
    worker = _mine.worker = ready(getattr(_mine, "worker", None))
    worker.begin(case, timeout)
    while (outcome := worker.poll()) is None:
        known = here.state.tasks.get(task)  # Dask only marks a running task as cancelled
        if known is None or known.state == "cancelled":
            worker.kill()
            break
        wait(worker.sources(), TICK)
    return outcome
