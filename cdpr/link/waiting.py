"""Telling who started a run that it waits for a peer, which is not there yet."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

_listeners: list[Callable[[str], None]] = []


@contextmanager
def waits_told(tell: Callable[[str], None]) -> Iterator[None]:
    """Call `tell` with a line of text whenever, meanwhile, a peer is waited for that does not listen yet."""
    _listeners.append(tell)
    try:
        yield
    finally:
        _listeners.remove(tell)


def tell_wait(called: str, seconds: float) -> None:
    """Say that a peer is waited for, for so long at most."""
    for tell in _listeners:
        tell(f"waiting up to {seconds:.3g} s for {called}, which does not listen yet")
