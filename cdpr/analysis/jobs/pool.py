"""Execution of cases in worker processes: a crash, a hang or an exit affects only the current case.

The standard library's pools are not robust enough: ProcessPoolExecutor lost 18 of 20 tasks after one killed worker, and
multiprocessing.Pool hung.
"""

from __future__ import annotations

import contextlib
import os
from collections import deque
from collections.abc import Callable, Sequence
from math import inf
from multiprocessing.connection import Connection, Pipe, wait
from time import monotonic
from typing import Any, Protocol

from cdpr.analysis.jobs import forks
from cdpr.analysis.jobs.cases import BEGUN, Case, Outcome
from cdpr.base.errors import ExitCode
from cdpr.base.processes import ended

__all__ = ["TICK", "Case", "Executor", "Outcome", "Worker", "ready", "run_cases", "wait"]

STARTING = 120.0  # s, time limit for imports and setup of a case, in addition to its own limit
TICK = 0.5  # s between two checks of a worker
PIPE = 65536  # capacity of a pipe, bytes
TAIL = 16384  # bytes of a worker's output that are kept
LINES = 30  # lines of it in the message of a crash
NOISE = "Extension modules:"  # faulthandler's list of loaded modules

Done = Callable[[Outcome], None]


class Executor(Protocol):
    """Executor of cases; it calls `done` with each outcome as soon as a case has ended."""

    def __call__(self, cases: Sequence[Case], *, timeout: float | None, done: Done) -> object:
        """Run all cases and return when all have ended."""


def run_cases(
    cases: Sequence[Case], *, jobs: int, timeout: float | None, done: Done = lambda outcome: None
) -> list[Outcome]:
    """Run all cases and return their outcomes in order. No worker outlives this call or this process.

    Args:
        cases: cases with unique keys.
        jobs: number of workers.
        timeout: time after the first step at which a case counts as hung, s; None for no limit.
        done: called with each outcome; its exceptions end all workers.
    """
    waiting = deque(cases)
    outcomes: dict[str, Outcome] = {}
    workers: list[Worker] = []
    try:
        for _ in range(min(jobs, len(cases))):
            workers.append(Worker())
            workers[-1].begin(waiting.popleft(), timeout)
        while busy := [worker for worker in workers if worker.case]:
            wait([source for worker in busy for source in worker.sources()], TICK)
            for k, worker in enumerate(workers):
                outcome = worker.poll()
                if outcome is None:
                    continue
                if waiting:
                    workers[k] = ready(worker)
                    workers[k].begin(waiting.popleft(), timeout)
                outcomes[outcome.key] = outcome
                done(outcome)
    finally:
        for worker in workers:
            worker.kill()
    return [outcomes[case.key] for case in cases]


class Worker:
    """Process that runs one case at a time; unusable after a death or a hang."""

    def __init__(self) -> None:
        self.case: Case | None = None
        self._open = True
        self._timeout = self._limit = self._deadline = inf
        self._connection, theirs = Pipe()
        self._output, output = os.pipe()
        os.set_blocking(self._output, False)
        self._captured = b""
        self._mute = False
        with theirs:
            try:
                self._process = forks.fork([theirs.fileno(), output])
            finally:
                os.close(output)
        around = forks.Surroundings.ours()
        with contextlib.suppress(OSError):  # it has died: `poll` detects that
            self._connection.send(around)

    def begin(self, case: Case, timeout: float | None) -> None:
        """Send a case to an idle worker."""
        self.case, self._captured = case, b""
        self._timeout = inf if timeout is None else timeout
        self._limit = STARTING + self._timeout
        self._deadline = monotonic() + self._limit
        with contextlib.suppress(OSError):  # it has just died: `poll` detects that
            self._connection.send(case)

    def sources(self) -> list[Connection | int]:
        """Return the objects that become readable when `look` has something to do."""
        return [self._connection] if self._mute else [self._connection, self._output]

    def poll(self) -> Outcome | None:
        """Return the outcome of the case, or None while it runs; never block."""
        if self.case is None:
            return None
        self._listen()
        try:
            while self._connection.poll():
                answer: Any = self._connection.recv()
                if answer == BEGUN:
                    self._limit = self._timeout
                    self._deadline = monotonic() + self._limit
                else:
                    self.case = None
                    return answer  # type: ignore[no-any-return]
        except (EOFError, OSError):
            return self._lost("died")
        if self._process.poll() is not None:  # a process that it started keeps the socket open
            return self._lost("died")
        return self._lost("hung") if monotonic() > self._deadline else None

    @property
    def alive(self) -> bool:
        """True if the process runs; the system may have killed an idle one."""
        return self._open and self._process.poll() is None

    def kill(self) -> None:
        """Kill the process and all processes that it started."""
        if not self._open:
            return
        self._open = False
        self._process.kill()
        self._process.wait()
        self._listen()
        self._connection.close()
        os.close(self._output)

    def _lost(self, status: str) -> Outcome:
        """Kill the process and return the outcome of its case."""
        assert self.case is not None
        case, self.case = self.case, None
        if status == "died":
            self._process.wait(TICK)  # its socket is closed: it is about to exit
        self.kill()
        how = f"the process of this case {ended(self._process.returncode or 0)}"
        text = f"no answer after {self._limit:g} s" if status == "hung" else how
        lines = self._captured.decode(errors="replace").strip().splitlines()
        lines = [line for line in lines if not line.startswith(NOISE)]
        message = "\n".join([text, *lines[-LINES:]])
        return Outcome(case.key, status, message, case.out or "", code=ExitCode.BACKEND_DIED)

    def _listen(self) -> None:
        """Read the output of the process and keep its end."""
        with contextlib.suppress(BlockingIOError):
            chunk = os.read(self._output, PIPE)
            self._captured = (self._captured + chunk)[-TAIL:]
            self._mute = not chunk


def ready(worker: Worker | None) -> Worker:
    """Return an idle worker: the given one, or a new one if its process has ended."""
    if worker is not None and worker.alive:
        return worker
    if worker is not None:
        worker.kill()
    return Worker()
