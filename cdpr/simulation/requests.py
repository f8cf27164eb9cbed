"""Requests of other threads to a running simulation, and their queue."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Condition, Event, Lock
from typing import Any, Literal

from cdpr.base.errors import CdprError
from cdpr.simulation.clock import Clock

MOST = 200  # pending requests; beyond, awaited ones are rejected

Level = Literal["error", "warning", "info"]
Reply = Callable[[Level, str], None]


@dataclass(eq=False)
class Request:
    """External request.

    Attributes:
        what: name of the request, as `Driver` has a method `request_NAME`.
        values: its arguments.
        reply: receives messages about it, in the thread of the simulation.
        action: executed instead of the method of that name.
        done: set when the request was processed or refused.
        answer: "", or the reason of the refusal.
        awaited: True if somebody waits for the result.
    """

    what: str
    values: dict[str, Any] = field(default_factory=dict)
    reply: Reply | None = None
    action: Callable[[], object] | None = None
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

    def refuse(self, reason: str) -> None:
        """Answer with the reason of a refusal."""
        self.answer = reason
        self.done.set()


class Requests:
    """Queue of pending requests.

    Args:
        clock: clock of the waits; by default that of the machine.

    Attributes:
        clock: likewise.
    """

    def __init__(self, clock: Clock | None = None) -> None:
        self.clock = clock or Clock()
        self._waiting = deque[Request]()
        self._some = Condition()
        self._closed = ""  # reason

    def put(self, request: Request, *, awaited: bool = False) -> None:
        """Append a request.

        An unawaited request replaces the last pending one of its kind, so that a flood does not grow the queue. An
        awaited request in between prevents the replacement, to keep the order.

        Raises:
            CdprError: if too many requests are pending and the request is awaited.
        """
        with self._some:
            request.awaited = awaited
            if self._closed:
                request.refuse(self._closed)
                return
            if awaited and len(self._waiting) >= MOST:
                raise CdprError(f"{request.what}: rejected: {MOST} requests are pending")
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

    def get(self, timeout: float = 0.0) -> Request | None:
        """Return the first request, waiting up to `timeout` s; None if there is none."""
        until = self.clock.now() + timeout
        with self._some:
            while True:
                while self._waiting:
                    request = self._waiting.popleft()
                    if request.take():
                        return request
                left = until - self.clock.now()
                if left <= 0.0:
                    return None
                self.clock.wait(self._some, left)

    def close(self, reason: str) -> None:
        """Refuse all pending and later requests."""
        with self._some:
            self._closed = reason
            while self._waiting:
                if (request := self._waiting.popleft()).take():
                    request.refuse(reason)
