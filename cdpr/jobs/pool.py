"""Runs cases in worker processes: a crash, a hang or an exit costs the one case that was under way.

Not with the standard library's pools: of 20 tasks ProcessPoolExecutor lost 18 to one killed worker, and
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

from cdpr.errors import ExitCode
from cdpr.jobs import forks
from cdpr.jobs.cases import BEGUN, Case, Outcome
from cdpr.processes import ended

__all__ = ["TICK", "Case", "Executor", "Outcome", "Worker", "ready", "run_cases", "wait"]

STARTING = 120.0  # s that a case may take, beyond its own limit, to import and build before it begins
TICK = 0.5  # s between two looks whether a worker lives and is in time
PIPE = 65536  # bytes that a pipe holds
TAIL = 16384  # bytes kept of what a worker printed
LINES = 30  # of these shown with a crash
NOISE = "Extension modules:"  # faulthandler lists all that is loaded

Done = Callable[[Outcome], None]


class Executor(Protocol):
    """Runs cases wherever, and calls `done` with how each ended as soon as it did."""

    def __call__(self, cases: Sequence[Case], *, timeout: float | None, done: Done) -> object:
        """Return when all cases have ended."""


def run_cases(
    cases: Sequence[Case], *, jobs: int, timeout: float | None, done: Done = lambda outcome: None
) -> list[Outcome]:
    """Run all cases, `jobs` at a time, and return how each ended, in their order.

    A case that has not ended `timeout` seconds after its first step counts as hung. `done` is called with each outcome
    as it comes; what it raises ends everything. In any case no worker outlives this call, nor this process.
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
                outcome = worker.look()
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
    """A process that runs one case at a time; after a death or a hang it is used up."""

    def __init__(self) -> None:
        self.case: Case | None = None
        self._open = True
        self._timeout = self._limit = self._deadline = inf
        self._connection, theirs = Pipe()
        self._output, output = os.pipe()
        os.set_blocking(self._output, False)
        self._said = b""
        self._mute = False
        with theirs:
            try:
                self._process = forks.fork([theirs.fileno(), output])
            finally:
                os.close(output)
        around = forks.Surroundings.ours()
        with contextlib.suppress(OSError):  # it has died: `look` finds out
            self._connection.send(around)

    def begin(self, case: Case, timeout: float | None) -> None:
        """Send a case; the worker has none."""
        self.case, self._said = case, b""
        self._timeout = inf if timeout is None else timeout
        self._limit = STARTING + self._timeout
        self._deadline = monotonic() + self._limit
        with contextlib.suppress(OSError):  # it has just died: `look` finds out
            self._connection.send(case)

    def sources(self) -> list[Connection | int]:
        """What becomes readable when there is something to look at."""
        return [self._connection] if self._mute else [self._connection, self._output]

    def look(self) -> Outcome | None:
        """Return the outcome of the case, None while it runs; never waits."""
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
        if self._process.poll() is not None:  # and something that it started keeps the socket open
            return self._lost("died")
        return self._lost("hung") if monotonic() > self._deadline else None

    @property
    def alive(self) -> bool:
        """Whether there is a process; the system may have ended one that had no case."""
        return self._open and self._process.poll() is None

    def kill(self) -> None:
        """End the process at once, with all that it started."""
        if not self._open:
            return
        self._open = False
        self._process.kill()
        self._process.wait()
        self._listen()
        self._connection.close()
        os.close(self._output)

    def _lost(self, status: str) -> Outcome:
        """Give up the process and its case."""
        assert self.case is not None
        case, self.case = self.case, None
        if status == "died":
            self._process.wait(TICK)  # its socket is closed: it is about to end by itself
        self.kill()
        how = f"the process of this case {ended(self._process.returncode or 0)}"
        text = f"no answer after {self._limit:g} s" if status == "hung" else how
        said = self._said.decode(errors="replace").strip().splitlines()
        said = [line for line in said if not line.startswith(NOISE)]
        message = "\n".join([text, *said[-LINES:]])
        return Outcome(case.key, status, message, case.out or "", code=ExitCode.BACKEND_DIED)

    def _listen(self) -> None:
        """Take what the process printed, and keep the end of it."""
        with contextlib.suppress(BlockingIOError):
            chunk = os.read(self._output, PIPE)
            self._said = (self._said + chunk)[-TAIL:]
            self._mute = not chunk


def ready(worker: Worker | None) -> Worker:
    """Return a worker that can begin a case: this one, or another where its process has ended."""
    if worker is not None and worker.alive:
        return worker
    if worker is not None:
        worker.kill()
    return Worker()
