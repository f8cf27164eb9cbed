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
    here = False


@contextmanager
def waiting() -> Iterator[None]:
    """Let those that come here end at once what does nothing but wait, also where they would else be remembered."""
    main = threading.current_thread() is threading.main_thread()
    _Waiting.here = main or _Waiting.here
    try:
        yield
    finally:
        _Waiting.here = _Waiting.here and not main


def is_waiting() -> bool:
    """Whether the main thread does nothing but wait."""
    return _Waiting.here
