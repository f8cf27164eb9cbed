"""FMU in a separate process, whose failures are errors of one line here."""

from __future__ import annotations

import dataclasses
import json
import os
import select
import signal
import socket
import subprocess
import sys
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from time import monotonic
from typing import NoReturn
from weakref import finalize

import numpy as np

from cdpr.base import processes
from cdpr.base.errors import BackendDied, CdprError, FmuError, PlantEnded
from cdpr.fmu.run import worker
from cdpr.fmu.run.folder import Folder
from cdpr.fmu.run.instance import Instance, Plan, Setting
from cdpr.fmu.run.worker import DONE, FAILED, FORGET, HEAD, MOST, REFRESH, RESTORE, SAVE, START, STEP, TUNE

START_SECONDS = 30.0  # s, to start the process, load, instantiate and initialise
CLOSE_SECONDS = 0.5  # s, for the FMU to end by itself
LINES = 5  # kept lines of its output and log
LINE = 300  # bytes of each
CHUNK = 2**16

ERRORS: dict[str, type[CdprError]] = {kind.__name__: kind for kind in (BackendDied, FmuError, PlantEnded)}
# Uses the modules of this process, wherever they were found, and nothing from the folder of the FMU.
BOOT = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from cdpr.fmu.run import worker; worker.main(*json.loads(sys.argv[2]))"
)


class Process(Instance):
    """Instance in a worker process.

    Args:
        plan: data for the instance.
        folder: folder with the extracted FMU.
        timeout: longest wall time of a call of `step`, `refresh` and the like, s.
    """

    def __init__(self, plan: Plan, folder: Folder, timeout: float) -> None:
        super().__init__(plan, folder)
        self.timeout = timeout
        self._captured: deque[bytes] = deque(maxlen=LINES)
        self._partial = b""
        self._open = True
        self._kept: dict[int, int] = {}  # steps by number of the state
        self._received = self.outputs.view(np.uint8)
        self._line, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._pipe, printed = os.pipe()
        os.set_blocking(self._pipe, False)
        path = [os.path.abspath(entry) for entry in sys.path]
        job = (theirs.fileno(), os.getpid(), dataclasses.asdict(plan))
        try:
            self._process = processes.start(
                lambda: subprocess.Popen(
                    [sys.executable, "-P", "-c", BOOT, json.dumps(path), json.dumps(job)],
                    stdin=subprocess.DEVNULL,
                    stdout=printed,
                    stderr=printed,
                    pass_fds=[theirs.fileno()],
                    cwd=folder.path,
                    start_new_session=True,
                )
            )
        finally:
            theirs.close()
            os.close(printed)
        self._end = finalize(self, _end, self._process, self._line, self._pipe)
        self._poll = select.poll()
        self._poll.register(self._line, select.POLLIN)
        self._poll.register(self._pipe, select.POLLIN)
        self._wait("loading and instantiating", START_SECONDS)

    @property
    def pid(self) -> int:
        """Return the process id."""
        return self._process.pid

    def start(self, settings: Sequence[Setting]) -> None:
        """Initialise at time zero with these start values and the present inputs."""
        self.steps = 0
        self._request(START, 0, worker.encode(settings), "initialising", START_SECONDS)

    def step(self, n: int) -> None:
        """Advance by n communication steps."""
        self._request(STEP, n)
        self.steps += n

    def refresh(self) -> None:
        """Read the outputs for the present inputs without a step."""
        self._request(REFRESH)

    def tune(self, settings: Sequence[Setting]) -> None:
        """Change tunable parameters between two steps, and read the outputs."""
        self._request(TUNE, 0, worker.encode(settings))

    def save(self) -> int:
        """Save the present state, in the process, and return its number."""
        number = self._request(SAVE)
        self._kept[number] = self.steps
        return number

    def restore(self, number: int) -> None:
        """Restore a saved state; `inputs` do not change."""
        self._request(RESTORE, number)
        self.steps = self._kept[number]

    def forget(self, number: int) -> None:
        """Free a saved state."""
        del self._kept[number]
        self._request(FORGET, number)

    def end(self) -> None:
        """End the process, by force if necessary; may be called again."""
        if self._end.alive:
            with suppress(OSError):  # it is dead already
                self._line.shutdown(socket.SHUT_WR)
                self._answer(CLOSE_SECONDS)
            self._end()

    def _request(
        self, operation: bytes, number: int = 0, more: bytes = b"", what: str = "", seconds: float = 0.0
    ) -> int:
        """Send a request, copy the outputs of the answer and return its number."""
        if not self._end.alive:
            self._fail("is closed")
        request = HEAD.pack(operation, number) + self.inputs.tobytes() + more
        if len(request) > MOST:
            raise FmuError(f"FMU '{self.plan.name}': its parameters are more than {MOST} bytes; use isolation: inproc")
        with suppress(OSError):  # a dead process does not answer, which is noticed next
            self._line.send(request)
        return self._wait(what or "this step", seconds or self.timeout)

    def _wait(self, what: str, seconds: float) -> int:
        answer = self._answer(seconds)
        if not answer or answer[:1] != DONE:
            self._drain()  # last lines of the log
        if answer is None:
            self._end()
            self._fail(f"took more than {seconds:g} s for {what} and was stopped")
        if not answer:
            self._end()
            self._fail(_epitaph(self._process.returncode))
        if answer[:1] == FAILED:
            name, text = json.loads(answer[1:])
            raise ERRORS.get(name, BackendDied)(f"{text}{self._last_words}")
        if answer[:1] != DONE or len(answer) != HEAD.size + self.outputs.nbytes:
            self._end()
            self._fail("answered with nonsense; it may have damaged its process")
        self._received[:] = np.frombuffer(answer, np.uint8, offset=HEAD.size)
        _, number = HEAD.unpack_from(answer)
        return int(number)

    def _answer(self, seconds: float) -> bytes | None:
        """Return the next packet, b"" if the process is gone, None after the timeout."""
        deadline = monotonic() + seconds
        while (left := deadline - monotonic()) > 0.0:
            for descriptor, _ in self._poll.poll(1e3 * left):
                if descriptor == self._pipe:
                    self._drain()
                else:
                    try:
                        return self._line.recv(MOST)
                    except ConnectionError:
                        return b""
        return None

    def _drain(self) -> None:
        """Read new output and log messages of the FMU."""
        with suppress(BlockingIOError):
            text = os.read(self._pipe, CHUNK)
            if not text and self._open:  # nobody can write any more; the answer shows the state of the process
                self._poll.unregister(self._pipe)
                self._open = False
            lines = (self._partial + text).split(b"\n")
            self._partial = lines.pop()[-LINE:]
            self._captured.extend(line[:LINE] for line in lines if line.strip())

    @property
    def _last_words(self) -> str:
        lines = [*self._captured, self._partial]
        words = " | ".join(" ".join(line.decode(errors="replace").split()) for line in lines if line.strip())
        return f"; its output: {words}" if words else ""

    def _fail(self, text: str) -> NoReturn:
        raise BackendDied(f"FMU '{self.plan.name}' {text}{self._last_words}")


def _end(process: subprocess.Popen[bytes], line: socket.socket, pipe: int) -> None:
    """Kill the process and all that it started, and close the connections."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)  # not yet waited for, so the number is still its own
    process.wait()
    line.close()
    os.close(pipe)


def _epitaph(code: int) -> str:
    if code < 0:
        number = signal.Signals(-code)
        return f"crashed: its process was ended by {number.name} ({signal.strsignal(number)})"
    return f"ended its process with exit code {code}"
