"""Notification of the user while a run waits, such as for a peer."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

_listeners: list[Callable[[str], None]] = []


@contextmanager
def report_waits(report: Callable[[str], None]) -> Iterator[None]:
    """Call `report` with a line of text whenever, in this context, a run waits for a long time."""
    _listeners.append(report)
    try:
        yield
    finally:
        _listeners.remove(report)


def report_wait(called: str, seconds: float) -> None:
    """Report that a run waits for a peer, at most `seconds`."""
    report_line(f"waiting up to {seconds:.3g} s for {called}, which does not listen yet")


def report_line(text: str) -> None:
    """Report a line of text."""
    for report in _listeners:
        report(text)
