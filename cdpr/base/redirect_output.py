"""Redirection of foreign output: in commands of `cdpr` it goes to stderr, because it is no result.

No stream is replaced: a thread marks that it runs foreign code, and the command's own stdout (`cdpr.ui.cli.streams`)
checks the mark. So several threads may load plugins and print concurrently. In a program that uses cdpr as a library,
output of plugins goes to the program's stdout.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
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
    """Discard all output of the process inside the block, including output of native code."""
    with _stdout:
        _flush()
        kept = [os.dup(fd) for fd in (1, 2)]
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for fd in (1, 2):
            os.dup2(nowhere, fd)
        os.close(nowhere)
        try:
            yield
        finally:
            _flush()
            for fd, copy in zip((1, 2), kept, strict=True):
                os.dup2(copy, fd)
                os.close(copy)


def _flush() -> None:
    """Flush the buffers of Python and C, whose content belongs to earlier writers."""
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    ctypes.CDLL(None).fflush(None)


def is_redirected() -> bool:
    """Return True if this thread runs foreign code."""
    return _foreign.get()
