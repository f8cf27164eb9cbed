"""Worker processes as forks of one preloaded process, each started within milliseconds.

The preloaded process has a single thread, runs no case and loads no plugin, so that its forks share no state. It is the
parent of the workers, so it reports their exit statuses.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import subprocess
import sys
import threading
import weakref
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from struct import Struct

from cdpr.base import processes
from cdpr.base.errors import CdprError

START, LOOK = b"S", b"L"  # requests: start a fork with these descriptors; report the status of one
NUMBER = Struct("q")  # number of a process, or its status as by `os.waitpid`
RUNNING = -1  # no valid status
LOADING = 120.0  # s, time limit of the first imports
TRIES = 2  # the system may have killed the first process

# One thread each: there are as many workers as cores.
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True)
class Surroundings:
    """Environment of a worker: that of this process, independent of the working folder's content, with one thread."""

    folder: str
    path: tuple[str, ...]  # module search path
    environment: dict[str, str]

    @classmethod
    def ours(cls) -> Surroundings:
        """Return the environment of this process."""
        try:
            folder = os.getcwd()
        except OSError:  # the folder was removed
            folder = os.sep
        path = tuple(part or folder for part in sys.path)
        one = dict.fromkeys(ONE_THREAD, "1")
        return cls(folder, path, {**os.environ, "PYTHONPATH": os.pathsep.join(path), **one})

    def enter(self) -> None:
        """Apply it to this process."""
        os.environ.clear()
        os.environ.update(self.environment)
        sys.path[:] = self.path
        with suppress(OSError):  # the folder is gone
            os.chdir(self.folder)


class Fork:
    """Forked process.

    Attributes:
        pid: its number.
        returncode: exit status, as in `subprocess.Popen`; None while unknown.
    """

    def __init__(self, server: _Server, pid: int) -> None:
        self._server = server
        self.pid = pid
        self.returncode: int | None = None
        self._end: int | None = None  # readable after the process has ended
        with suppress(ProcessLookupError):
            self._end = os.pidfd_open(pid)
            weakref.finalize(self, os.close, self._end)

    def poll(self) -> int | None:
        """Return the exit status; None while the process runs."""
        if self.returncode is None and self._ended(0.0):
            self.returncode = self._server.poll(self.pid)
        return self.returncode

    def wait(self, timeout: float | None = None) -> None:
        """Wait for the end of the process, at most `timeout` seconds if given."""
        self._ended(timeout)
        self.poll()

    def _ended(self, timeout: float | None) -> bool:
        if self._end is None:
            return True
        poller = select.poll()
        poller.register(self._end, select.POLLIN)
        return bool(poller.poll(None if timeout is None else 1e3 * timeout))

    def kill(self) -> None:
        """Kill the process and all processes that it started."""
        with suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)


class _Server:
    """Connection to the preloaded process that forks the workers; the process ends with this object."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._socket, theirs = socket.socketpair()
        self._socket.settimeout(LOADING)
        module = [sys.executable, "-P", "-u", "-m", "cdpr.analysis.jobs.worker"]
        with theirs:
            self._process = processes.start(
                lambda: subprocess.Popen(
                    [*module, str(theirs.fileno()), str(os.getpid())],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    env=Surroundings.ours().environment,
                    pass_fds=[theirs.fileno()],
                    start_new_session=True,  # Ctrl-C must not reach it
                )
            )
        weakref.finalize(self, _end, self._socket, self._process)

    @property
    def alive(self) -> bool:
        """True if the process runs."""
        return self._process.poll() is None

    def start(self, descriptors: Sequence[int]) -> int | None:
        """Return the number of a new worker with these descriptors; None if the preloaded process is gone."""
        return self._request(START, descriptors)

    def poll(self, pid: int) -> int | None:
        """Return the exit status of a worker; None while it runs."""
        status = self._request(LOOK + NUMBER.pack(pid))
        if status is None:  # the workers are gone, too
            return -signal.SIGKILL
        return None if status == RUNNING else os.waitstatus_to_exitcode(status)

    def _request(self, what: bytes, descriptors: Sequence[int] = ()) -> int | None:
        with self._lock:
            try:
                socket.send_fds(self._socket, [what], descriptors)
                answer = self._socket.recv(NUMBER.size, socket.MSG_WAITALL)
            except OSError:  # it is gone or hangs
                answer = b""
            except BaseException:  # after an interrupt, the next answer would belong to this request
                _end(self._socket, self._process)
                raise
            if len(answer) < NUMBER.size:
                _end(self._socket, self._process)
                return None
        return int(NUMBER.unpack(answer)[0])


def _end(connection: socket.socket, process: subprocess.Popen[bytes]) -> None:
    connection.close()
    process.kill()
    process.wait()


def begin() -> None:
    """Start the preloaded process; it imports its modules in the background."""
    _server()


def fork(descriptors: Sequence[int]) -> Fork:
    """Return a new worker (see `cdpr.analysis.jobs.worker`).

    The first descriptor is its socket, the second receives its output.

    Raises:
        CdprError: if no worker can be started.
    """
    for _ in range(TRIES):
        server = _server()
        pid = server.start(descriptors)
        if pid is not None and pid > 0:
            return Fork(server, pid)
    raise CdprError("cannot start a worker process: see the reason above, or the system has no resources for more")


def _server() -> _Server:
    with _starting:
        here = os.getpid()  # a fork of this process inherits none of its locks and threads
        if here not in _known or not _known[here].alive:
            _known[here] = _Server()
        return _known[here]


_starting = threading.Lock()
_known: dict[int, _Server] = {}
