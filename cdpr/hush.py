"""What foreign code prints is no result: where `cdpr` runs as a command, it goes to stderr.

Nothing is swapped: a thread says that it runs foreign code, and the command's own stdout (`cdpr.cli.streams`) looks at
that. So several threads may load plugins and print at once. In a program that uses cdpr as a library, what a plugin
prints goes where that program has its stdout.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_foreign: ContextVar[bool] = ContextVar("foreign", default=False)


@contextmanager
def hushed() -> Iterator[None]:
    """Say that this thread runs foreign code inside the block."""
    token = _foreign.set(True)
    try:
        yield
    finally:
        _foreign.reset(token)


def is_hushed() -> bool:
    """Tell whether this thread runs foreign code."""
    return _foreign.get()
