"""What foreign code prints is no result: where `cdpr` runs as a command, it goes to stderr.

Nothing is swapped: a thread says that it runs foreign code, and the command's own stdout (`cdpr.cli.streams`) looks at
that. So several threads may load plugins and print at once. In a program that uses cdpr as a library, what a plugin
prints goes where that program has its stdout.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock

_foreign: ContextVar[bool] = ContextVar("foreign", default=False)
_stdout = Lock()  # of the process: two threads that replace it at once would leave the replacement in its place


@contextmanager
def hushed() -> Iterator[None]:
    """Say that this thread runs foreign code inside the block."""
    token = _foreign.set(True)
    try:
        yield
    finally:
        _foreign.reset(token)


@contextmanager
def native_to_stderr() -> Iterator[None]:
    """Send what native code prints on stdout inside the block to stderr: of libraries that have no switch for it.

    For calls made once, such as constructors: the whole process has but one stdout.
    """
    with _stdout:
        out = _redirected()
        try:
            yield
        finally:
            if out is not None:
                os.dup2(out, 1)
                os.close(out)


def _redirected() -> int | None:
    """Send stdout to stderr; return a copy of stdout, None where either is closed and nothing is changed."""
    try:
        sys.stdout.flush()
        out = os.dup(1)
    except (AttributeError, OSError, ValueError):
        return None
    try:
        os.dup2(2, 1)
    except OSError:
        os.close(out)
        return None
    return out


def is_hushed() -> bool:
    """Tell whether this thread runs foreign code."""
    return _foreign.get()
