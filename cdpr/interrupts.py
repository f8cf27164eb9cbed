"""Signals by which a process is asked to end, and what must not be cut short by them."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Let those that Python handles wait until the end of what takes less than a second."""
    came: list[int] = []
    before = {}
    if threading.current_thread() is threading.main_thread():  # no other is interrupted
        before = {number: handler for number in STOPPING if callable(handler := signal.getsignal(number))}
    try:
        for number in before:
            signal.signal(number, lambda number, frame: came.append(number))
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for each in came:
            signal.raise_signal(each)


class _Waiting:
    """Lets those that come within its block end at once what does nothing but wait, also where they were remembered.

    Attributes:
        here: whether the main thread is in such a block.
    """

    here = False

    def __enter__(self) -> None:
        if threading.current_thread() is threading.main_thread():
            self.here = True

    def __exit__(self, *error: object) -> None:
        if threading.current_thread() is threading.main_thread():
            self.here = False


WAITING = _Waiting()
