"""Redirection of foreign output: in commands of `cdpr` it goes to stderr, because it is no result.

No stream is replaced: a thread marks that it runs foreign code, and the command's own stdout (`cdpr.ui.cli.streams`)
checks the mark. So several threads may load plugins and print concurrently. In a program that uses cdpr as a library,
output of plugins goes to the program's stdout.
"""

from __future__ import annotations

import ctypes
import fcntl
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from threading import Lock

_foreign: ContextVar[bool] = ContextVar("foreign", default=False)
_stdout = Lock()  # of the process: concurrent replacements would make the replacement permanent


@contextmanager
def redirect_output() -> Iterator[None]:
    """Mark that this thread runs foreign code inside the block."""
    token = _foreign.set(True)
    try:
        yield
    finally:
        _foreign.reset(token)


@contextmanager
def discarded_output() -> Iterator[None]:
    """Discard all output of the process inside the block, including output of native code.

    A closed stdout or stderr is closed again after the block.
    """
    with _stdout:
        _flush()
        kept = {fd: _copy(fd) for fd in (1, 2)}
        nowhere = os.open(os.devnull, os.O_WRONLY)  # may get the number of a closed stream
        for fd in kept:
            os.dup2(nowhere, fd)
        if nowhere not in kept:
            os.close(nowhere)
        try:
            yield
        finally:
            _flush()
            for fd, copy in kept.items():
                if copy is None:
                    os.close(fd)
                else:
                    os.dup2(copy, fd)
                    os.close(copy)


def open_closed_streams() -> None:
    """Open the null device in place of closed standard streams: a file would get their number, and foreign output."""
    for fd in (0, 1, 2):
        try:
            os.fstat(fd)
        except OSError:
            nowhere = os.open(os.devnull, os.O_RDWR)  # gets this number, unless another thread opens a file
            if nowhere == fd:
                os.set_inheritable(fd, True)  # child processes get it, too
            else:
                os.dup2(nowhere, fd)
                os.close(nowhere)


def _copy(fd: int) -> int | None:
    """Return a copy of a descriptor, above those of the standard streams; None if it is closed."""
    try:
        return fcntl.fcntl(fd, fcntl.F_DUPFD_CLOEXEC, 3)
    except OSError:
        return None


def _flush() -> None:
    """Flush the buffers of Python and C, whose content belongs to earlier writers."""
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            with suppress(OSError, ValueError):  # full, or closed; the next write reports it
                stream.flush()
    ctypes.CDLL(None).fflush(None)


def is_redirected() -> bool:
    """Return True if this thread runs foreign code."""
    return _foreign.get()
