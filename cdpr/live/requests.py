"""What others ask a running simulation for, from threads of their own, and what waits to be done."""

from __future__ import annotations

import queue
from collections import deque
from dataclasses import dataclass, field
from threading import Condition, Event, Lock
from time import monotonic
from typing import Any


@dataclass(eq=False)
class Request:
    """Something that was asked for from outside.

    Attributes:
        what: a key of `cdpr.live.drive.REQUESTS`.
        values: what it needs.
        done: set when it was done, or refused.
        answer: "" or why it was refused.
        awaited: whether somebody waits for that.
    """

    what: str
    values: dict[str, Any] = field(default_factory=dict)
    done: Event = field(default_factory=Event)
    answer: str = ""
    awaited: bool = False
    _taken: Any = field(default_factory=Lock)

    @property
    def kind(self) -> tuple[str, Any]:
        """What it is one of many of."""
        return self.what, self.values.get("key")

    def take(self) -> bool:
        """Return whether nobody took it before: either it is done, once, or who asked gave up, and it never is."""
        return bool(self._taken.acquire(blocking=False))


class Requests:
    """What was asked for and is not done yet, in its order."""

    def __init__(self) -> None:
        self._waiting = deque[Request]()
        self._some = Condition()

    def put(self, request: Request, *, awaited: bool = False) -> None:
        """Let it wait for its turn.

        What nobody waits for takes the place of an earlier one of its kind, which would be in force for no time at all:
        no flood grows. What somebody waits for in between keeps that.
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
        """Return the first, waiting for one for so long (s) at most. Raises queue.Empty where there is none."""
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
