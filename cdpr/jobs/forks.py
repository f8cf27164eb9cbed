"""Worker processes as forks of one process that has loaded all: each begins in milliseconds.

That process has no thread beside its own, runs no case and loads no plugin, so that its forks inherit nothing that they
could share. It, not we, is their parent: it is asked how they ended.
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

from cdpr import processes
from cdpr.errors import CdprError

START, LOOK = b"S", b"L"  # what is asked: a fork with these descriptors; how one ended
NUMBER = Struct("q")  # of a process, and what `os.waitpid` says of it
RUNNING = -1  # no such status
LOADING = 120.0  # s after which it hangs: it has but to import
TRIES = 2  # the system may have ended the first process meanwhile

# One thread each: the workers are as many as the cores, and must not fight for them.
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True)
class Surroundings:
    """What a worker finds around it: as we, whatever the working folder holds, but one thread."""

    folder: str
    path: tuple[str, ...]  # of modules
    environment: dict[str, str]

    @classmethod
    def ours(cls) -> Surroundings:
        """Return those of this process."""
        try:
            folder = os.getcwd()
        except OSError:  # it was removed
            folder = os.sep
        path = tuple(part or folder for part in sys.path)
        one = dict.fromkeys(ONE_THREAD, "1")
        return cls(folder, path, {**os.environ, "PYTHONPATH": os.pathsep.join(path), **one})

    def enter(self) -> None:
        """Let them be those of this process."""
        os.environ.clear()
        os.environ.update(self.environment)
        sys.path[:] = self.path
        with suppress(OSError):  # it is gone
            os.chdir(self.folder)


class Fork:
    """A forked process.

    Attributes:
        pid: its number.
        returncode: how it ended, as `subprocess.Popen` says; None while nobody knows.
    """

    def __init__(self, server: _Server, pid: int) -> None:
        self._server = server
        self.pid = pid
        self.returncode: int | None = None
        self._end: int | None = None  # becomes readable with its end
        with suppress(ProcessLookupError):
            self._end = os.pidfd_open(pid)
            weakref.finalize(self, os.close, self._end)

    def poll(self) -> int | None:
        """Return how it ended, None while it runs."""
        if self.returncode is None and self._ended(0.0):
            self.returncode = self._server.look(self.pid)
        return self.returncode

    def wait(self, timeout: float | None = None) -> None:
        """Wait until it has ended, for at most so many seconds if it is said."""
        self._ended(timeout)
        self.poll()

    def _ended(self, timeout: float | None) -> bool:
        if self._end is None:
            return True
        look = select.poll()
        look.register(self._end, select.POLLIN)
        return bool(look.poll(None if timeout is None else 1e3 * timeout))

    def kill(self) -> None:
        """End it at once, with all that it started."""
        with suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)


class _Server:
    """Our end of the process whose forks the workers are; it ends with this object."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._socket, theirs = socket.socketpair()
        self._socket.settimeout(LOADING)
        module = [sys.executable, "-P", "-u", "-m", "cdpr.jobs.worker"]
        with theirs:
            self._process = processes.start(
                lambda: subprocess.Popen(
                    [*module, str(theirs.fileno()), str(os.getpid())],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    env=Surroundings.ours().environment,
                    pass_fds=[theirs.fileno()],
                    start_new_session=True,  # Ctrl-C is for us
                )
            )
        weakref.finalize(self, _end, self._socket, self._process)

    @property
    def alive(self) -> bool:
        """Whether it can be asked."""
        return self._process.poll() is None

    def start(self, descriptors: Sequence[int]) -> int | None:
        """Return the number of a new worker with these descriptors; None where this process is gone."""
        return self._ask(START, descriptors)

    def look(self, pid: int) -> int | None:
        """Return how a worker ended, as a return code; None while it runs."""
        status = self._ask(LOOK + NUMBER.pack(pid))
        if status is None:  # the workers are gone, too
            return -signal.SIGKILL
        return None if status == RUNNING else os.waitstatus_to_exitcode(status)

    def _ask(self, what: bytes, descriptors: Sequence[int] = ()) -> int | None:
        with self._lock:
            try:
                socket.send_fds(self._socket, [what], descriptors)
                answer = self._socket.recv(NUMBER.size, socket.MSG_WAITALL)
            except OSError:  # it is gone, or hangs
                answer = b""
            except BaseException:  # an interrupt: what comes next would be the answer to this question
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
    """Start what the workers are forked from: its modules load while other things are done."""
    _server()


def fork(descriptors: Sequence[int]) -> Fork:
    """Return a new worker, see `cdpr.jobs.worker`: its socket is the first descriptor, the second takes its output.

    Raises CdprError where none can be started.
    """
    for _ in range(TRIES):
        server = _server()
        pid = server.start(descriptors)
        if pid is not None and pid > 0:
            return Fork(server, pid)
    raise CdprError("no worker process can be started: its reason stands above, or the system has no room for more")


def _server() -> _Server:
    with _starting:
        here = os.getpid()  # a fork of us has none of our locks and threads
        if here not in _known or not _known[here].alive:
            _known[here] = _Server()
        return _known[here]


_starting = threading.Lock()
_known: dict[int, _Server] = {}
