"""Requests of other threads to a running simulation, and their queue."""

from __future__ import annotations

import queue
from collections import deque
from dataclasses import dataclass, field
from threading import Condition, Event, Lock
from time import monotonic
from typing import Any


@dataclass(eq=False)
class Request:
    """External request.

    Attributes:
        what: key of `cdpr.ui.live.drive.REQUESTS`.
        values: its arguments.
        done: set when the request was processed or refused.
        answer: "", or the reason of the refusal.
        awaited: True if somebody waits for the result.
    """

    what: str
    values: dict[str, Any] = field(default_factory=dict)
    done: Event = field(default_factory=Event)
    answer: str = ""
    awaited: bool = False
    _taken: Any = field(default_factory=Lock)

    @property
    def kind(self) -> tuple[str, Any]:
        """Kind of the request; a later request replaces an earlier one of its kind."""
        return self.what, self.values.get("key")

    def take(self) -> bool:
        """Return True for the first caller only: the request is either processed once or abandoned by its sender."""
        return bool(self._taken.acquire(blocking=False))


class Requests:
    """Queue of pending requests."""

    def __init__(self) -> None:
        self._waiting = deque[Request]()
        self._some = Condition()

    def put(self, request: Request, *, awaited: bool = False) -> None:
        """Append a request.

        An unawaited request replaces the last pending one of its kind, so that a flood does not grow the queue. An
        awaited request in between prevents the replacement, to keep the order.
        """
        with self._some:
            request.awaited = awaited
            if not awaited:
                self._forget(request.kind)
            self._waiting.append(request)
            self._some.notify()

    def _forget(self, kind: tuple[str, Any]) -> None:
        for one in reversed(self._waiting):
            if one.awaited:
                return
            if one.kind == kind:
                self._waiting.remove(one)
                one.done.set()
                return

    def get(self, timeout: float = 0.0) -> Request:
        """Return the first request, waiting up to `timeout` s.

        Raises:
            queue.Empty: if there is none.
        """
        until = monotonic() + timeout
        with self._some:
            while True:
                while self._waiting:
                    request = self._waiting.popleft()
                    if request.take():
                        return request
                left = until - monotonic()
                if left <= 0.0:
                    raise queue.Empty
                self._some.wait(left)
