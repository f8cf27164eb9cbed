"""The cases of a study on a Dask cluster: each in a worker process of its own beside the cluster's."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from cdpr.errors import CdprError, ExitCode, PluginError, one_line
from cdpr.simulation.pool import TICK, Case, Outcome, ready, wait
from cdpr.study.folder import clear
from cdpr.study.run import Executor

CONNECTING = 20  # s to find the scheduler

NOISY = ("distributed", "tornado")  # what they tell as tracebacks is told here, or mended

_mine = threading.local()  # a worker process for each thread of a cluster's worker, kept from case to case


def executor(address: str) -> Executor:
    """Return what runs cases on the cluster whose scheduler is at `address`, such as tcp://host:8786.

    Raises PluginError without distributed, CdprError where nothing answers.
    """
    try:
        import distributed
    except ImportError as error:
        raise PluginError("a cluster needs distributed, which is not installed: pip install 'cdpr[cluster]'") from error

    def execute(cases: Sequence[Case], *, timeout: float | None, done: Callable[[Outcome], None]) -> None:
        if not cases:
            return
        for name in [name for name in logging.root.manager.loggerDict if name.partition(".")[0] in NOISY]:
            logging.getLogger(name).setLevel(logging.CRITICAL)  # its configuration gives each a level of its own
        try:
            client = distributed.Client(address, timeout=CONNECTING)
        except (OSError, ValueError, TypeError) as error:  # TypeError: tls:// without certificates
            raise CdprError(f"--scheduler {address}: no Dask scheduler answers there: {one_line(error)}") from error
        with client:  # once it is closed, however this ends, nobody waits for the cases any more: see `run_here`
            run = partial(run_here, timeout=timeout)
            try:
                futures = {client.submit(run, case, pure=False): case.key for case in cases}
                for future in distributed.as_completed(futures):
                    done(_outcome(future, futures[future]))
            except CdprError:
                raise
            except Exception as error:
                if client.status == "running":
                    raise
                raise _Lost(f"the scheduler at {address} is gone; the cases that had ended are kept") from error

    return execute


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


def _outcome(future: Any, key: str) -> Outcome:
    error = future.exception()
    if error is None:
        return future.result()  # type: ignore[no-any-return]
    return Outcome(key, "died", f"lost by the cluster: {one_line(error)}", "", code=ExitCode.BACKEND_DIED)
