"""Signals that end a process, and protection of short operations from them."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Delay signals handled by Python until the end of an operation that takes less than a second."""
    came: list[int] = []
    before = {}
    if threading.current_thread() is threading.main_thread():  # other threads are not interrupted
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
    """Context in which signals end a mere waiting at once, even if they would otherwise be stored.

    Attributes:
        here: True if the main thread is in such a context.
    """

    here = False

    def __enter__(self) -> None:
        if threading.current_thread() is threading.main_thread():
            self.here = True

    def __exit__(self, *error: object) -> None:
        if threading.current_thread() is threading.main_thread():
            self.here = False


WAITING = _Waiting()
