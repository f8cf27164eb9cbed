"""A Dask cluster: jobs of any kind on it, and the cases of a study, each in a process beside the cluster's."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from cdpr.errors import CdprError, ExitCode, PluginError, one_line
from cdpr.jobs.folder import clear
from cdpr.jobs.pool import TICK, Case, Executor, Outcome, ready, wait

CONNECTING = 20  # s to find the scheduler

GONE = "the scheduler at {} is gone; the cases that had ended are kept"

NOISY = ("distributed", "tornado")  # what they tell as tracebacks is told here, or mended

J = TypeVar("J")
R = TypeVar("R")

_mine = threading.local()  # a worker process for each thread of a cluster's worker, kept from case to case


def executor(address: str) -> Executor:
    """Return what runs cases on the cluster whose scheduler is at `address`, such as tcp://host:8786.

    Raises PluginError without distributed, CdprError where nothing answers.
    """
    check_installed()

    def execute(cases: Sequence[Case], *, timeout: float | None, done: Callable[[Outcome], None]) -> None:
        def end(key: str, outcome: Outcome | None, lost: str) -> None:
            done(outcome or Outcome(key, "died", lost, "", code=ExitCode.BACKEND_DIED))

        spread(address, partial(run_here, timeout=timeout), {case.key: case for case in cases}, end)

    return execute


def check_installed() -> None:
    """Raise PluginError without distributed."""
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
    """Run jobs, by key, on a cluster, and tell of each as it ends: its key, and what `run` returned or how it was lost.

    The cluster has all of them at once, or `ahead` for each of its threads: what they return waits in its memory.

    Raises as `executor`, and CdprError where the scheduler goes away.
    """
    check_installed()
    import distributed

    if not jobs:
        return
    for name in [name for name in logging.root.manager.loggerDict if name.partition(".")[0] in NOISY]:
        logging.getLogger(name).setLevel(logging.CRITICAL)  # its configuration gives each a level of its own
    try:
        client = distributed.Client(address, timeout=CONNECTING)
    except (OSError, ValueError, TypeError) as error:  # TypeError: tls:// without certificates
        raise CdprError(f"--scheduler {address}: no Dask scheduler answers there: {one_line(error)}") from error
    with client:  # once it is closed, however this ends, nobody waits for the jobs any more: see `run_here`
        try:
            waiting = iter(jobs.items())
            futures = {client.submit(run, job, pure=False): key for key, job in islice(waiting, _room(client, ahead))}
            completed = distributed.as_completed(futures)
            for future in completed:
                try:
                    fault = future.exception()
                    result = future.result() if fault is None else None
                except OSError as error:  # its connection broke, which the client has not noticed yet
                    raise _Lost(GONE.format(address)) from error
                lost = "" if fault is None else f"lost by the cluster: {one_line(fault)}"
                done(futures.pop(future), result, lost)
                future.release()  # what it holds may be large
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
    """How many jobs the cluster may be given beside those that it has; its workers come and go."""
    return None if ahead is None else max(0, ahead * max(1, sum(client.nthreads().values())) - has)


class _Lost(CdprError):  # noqa: N818 - as SimulationStopped
    exit_code = ExitCode.BACKEND_DIED


def run_here(case: Case, timeout: float | None) -> Outcome | None:
    """Run a case in the worker process of this thread, which ends with it; None where it was cancelled meanwhile."""
    from distributed import get_worker

    here = get_worker()
    task = here.get_current_task()
    if case.out is not None:
        clear(Path(case.out))  # the cluster runs a case anew whose machine it has lost
    worker = _mine.worker = ready(getattr(_mine, "worker", None))
    worker.begin(case, timeout)
    while (outcome := worker.look()) is None:
        known = here.state.tasks.get(task)  # Dask does not end a task that was cancelled under way, but marks it
        if known is None or known.state == "cancelled":
            worker.kill()
            break
        wait(worker.sources(), TICK)
    return outcome
