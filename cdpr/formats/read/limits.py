"""Resource limits for reading untrusted files: a forked process with limited CPU time, wall time and memory.

A C parser cannot be interrupted within this process, neither by a limit nor by Ctrl-C; a separate process can. Forking
avoids a second import of cdpr. The fork has only the calling thread; a lock held by another thread stays locked in it,
and the process is then killed after `WALL`. Programs with threads should import in a separate process, as the GUI does
(`cdpr.ui.gui.reading`).
"""

from __future__ import annotations

import gc
import math
import os
import pickle
import resource
import select
import signal
import sys
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NoReturn, TypeVar

from cdpr.base import processes
from cdpr.base.errors import CdprError, FormatError
from cdpr.model.frozen import given_number

SECONDS = 10.0  # default CPU time
WALL = 12.0  # wall time relative to CPU time, at least a minute: margin for busy machines and deadlocks
MINUTE = 60.0
APART = True  # tests of other features read in the same process, which is faster
MEMORY = 4 * 2**30  # bytes of address space in addition to that of the process

Result = TypeVar("Result")


def bounded(call: Callable[[], Result], path: str, seconds: float = SECONDS) -> Result:
    """Return the result of `call`, which reads an untrusted file, and propagate its exceptions.

    Args:
        call: run in a fork of this process; its result or error is pickled.
        path: the file, for messages.
        seconds: limit of CPU time.

    Raises:
        FormatError: if a limit is exceeded or the process dies.
    """
    seconds = given_number(seconds, "seconds", above=0.0)
    if not APART:
        return call()
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError, ValueError, OSError):
            stream.flush()
    parent = os.getpid()
    pid, ours, theirs = _forked(path)
    if pid == 0:
        os.close(ours)
        _answer(call, path, theirs, parent, seconds)
    os.close(theirs)
    code, longest = -signal.SIGKILL, max(MINUTE, WALL * seconds)
    try:
        content = _received(ours, longest)
    finally:  # also if interrupted
        os.close(ours)
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
        with suppress(ChildProcessError):
            code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    if content is None:
        raise FormatError(f"{path}: reading it takes more than {longest:g} s, and was stopped")
    result: Result = _result(content, path, code, seconds)
    return result


def _forked(path: str) -> tuple[int, int, int]:
    """Fork; return the child's process id (0 in the child) and both ends of a pipe."""
    ends: tuple[int, ...] = ()
    try:
        ends = os.pipe()
        return os.fork(), *ends
    except OSError as error:
        for end in ends:
            os.close(end)
        reason = error.strerror or error
        raise CdprError(f"{path}: cannot start a process to read it: {reason}; {processes.FEWER}") from error


def _result(content: bytes, path: str, code: int, seconds: float) -> Any:
    if not content:
        if code == -signal.SIGXCPU:
            raise FormatError(
                f"{path}: reading it takes more than {seconds:g} s of CPU time, and was stopped; a robot usually "
                "takes less than one. If the file is valid, increase the limit (--seconds N; in Python seconds=N)"
            )
        raise FormatError(f"{path}: the process that reads it {processes.ended(code)}; nothing was imported")
    kind, value = pickle.loads(content)
    if kind == "error":
        raise value
    if kind == "fault":
        name, text, trace = value
        fault: RuntimeError = type(name, (RuntimeError,), {})(text)  # displayed once, as `NAME: text`
        fault.add_note(trace)
        raise fault
    return value


def _received(descriptor: int, seconds: float) -> bytes | None:
    """Return the data received until the other end closes; None after a timeout."""
    parts, end = list[bytes](), time.monotonic() + seconds
    while True:
        ready, _, _ = select.select([descriptor], [], [], max(0.0, end - time.monotonic()))
        if not ready:
            return None
        part = os.read(descriptor, 2**16)
        if not part:
            return b"".join(parts)
        parts.append(part)


def _answer(call: Callable[[], object], path: str, out: int, parent: int, seconds: float) -> NoReturn:
    """Run `call` within limits, and send its result."""
    try:
        processes.end_with(parent)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent receives it and kills this process
        signal.signal(signal.SIGXCPU, signal.SIG_DFL)
        gc.disable()  # garbage collection would write to shared memory and thereby copy it
        _limit(resource.RLIMIT_CPU, math.ceil(seconds))
        addresses = resource.getrlimit(resource.RLIMIT_AS)
        _limit(resource.RLIMIT_AS, MEMORY + _addresses())
        try:
            answer: tuple[str, object] = ("result", call())
        except CdprError as error:
            answer = ("error", _picklable(error))
        except MemoryError:
            answer = ("error", FormatError(f"{path}: reading it takes more than {MEMORY // 2**30} GiB of memory"))
        except Exception as error:
            answer = ("fault", (type(error).__name__, str(error), traceback.format_exc()))
        resource.setrlimit(resource.RLIMIT_AS, addresses)  # sending the result needs memory
        content = pickle.dumps(answer)
        with os.fdopen(out, "wb") as file:
            file.write(content)
    finally:
        os._exit(0)  # do not flush or close the parent's files


def _limit(which: int, value: int) -> None:
    soft, hard = resource.getrlimit(which)
    allowed = [value, *(each for each in (soft, hard) if each != resource.RLIM_INFINITY)]
    with suppress(ValueError, OSError):
        resource.setrlimit(which, (min(allowed), hard))


def _addresses() -> int:
    """Return the size of this process's address space in bytes; 0 if unknown."""
    with suppress(OSError, ValueError, IndexError), open("/proc/self/statm") as file:
        return int(file.read().split()[0]) * resource.getpagesize()
    return 0


def _picklable(error: CdprError) -> CdprError:
    """Return an error that can be pickled."""
    with suppress(Exception):
        if str(pickle.loads(pickle.dumps(error))) == str(error):
            return error
    return FormatError(str(error))
