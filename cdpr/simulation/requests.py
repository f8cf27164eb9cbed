"""Requests of other threads to a running simulation, and their queue."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Container
from dataclasses import dataclass, field
from threading import Condition, Event, Lock
from typing import Any, Literal

from cdpr.base.errors import CdprError
from cdpr.simulation.clock import Clock

MAX_PENDING = 200  # pending requests; beyond, commands and new requests for cables are rejected
URGENT = ("stop", "close")  # requests that are executed, after earlier ones, before the next control step
REPLACED = "replaced by a later request"

Level = Literal["error", "warning", "info"]
Reply = Callable[[Level, str], None]


@dataclass(eq=False)
class Request:
    """External request.

    Attributes:
        what: name of the request, as `Driver` has a method `request_NAME`.
        values: its arguments.
        reply: receives messages about it, in the thread of the simulation, or of the sender if the queue is closed.
        action: executed instead of the method of that name.
        done: set when the request was executed, refused or replaced.
        answer: "" if it was executed, or why it was not.
        replaceable: True if a later request of its kind may replace it while it is pending.
    """

    what: str
    values: dict[str, Any] = field(default_factory=dict)
    reply: Reply | None = None
    action: Callable[[], object] | None = None
    done: Event = field(default_factory=Event)
    answer: str = ""
    replaceable: bool = True
    _taken: Any = field(default_factory=Lock)

    @property
    def kind(self) -> tuple[str, Any, tuple[str, ...]]:
        """Kind of the request; a later request of its kind replaces it. One for other cables is of another kind."""
        return self.what, self.values.get("key"), self.cables

    @property
    def cables(self) -> tuple[str, ...]:
        """Cables that it names."""
        return tuple(self.values.get("names", ()))

    def take(self) -> bool:
        """Return True for the first caller only: the request is either processed once or abandoned by its sender."""
        return bool(self._taken.acquire(blocking=False))

    @property
    def taken(self) -> bool:
        """True if it was processed or abandoned."""
        return bool(self._taken.locked())

    def refuse(self, reason: str) -> None:
        """Answer with the reason of a refusal."""
        self.answer = reason
        self.done.set()
        if self.reply is not None:
            self.reply("error", reason)


class CommandWarning(str):
    """Warning: the request was executed, but its result is probably not intended."""

    __slots__ = ()


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

    def put(self, request: Request, *, replaceable: bool = True) -> None:
        """Append a request, or refuse it if the queue is closed.

        A replaceable request, such as a message of a stream, replaces the last pending one of its kind, so that a flood
        does not grow the queue; the answer of the replaced one is `REPLACED`. A request that is not replaceable, such
        as a command, is executed in any case. It also prevents replacements of earlier requests, to keep the order.

        Args:
            request: request to append.
            replaceable: as above.

        Raises:
            CdprError: if too many requests are pending and this one is not replaceable, or is for cables and replaces
                none; one place more is kept for those of `URGENT`.
        """
        with self._some:
            request.replaceable = replaceable
            closed = self._closed
            if not closed:
                replaced = replaceable and self._replace(request.kind)
                limited = not replaceable or (request.cables and not replaced)  # there are few kinds without cables
                if limited and len(self._waiting) >= MAX_PENDING + (request.what in URGENT):
                    raise CdprError(f"{request.what}: rejected: {MAX_PENDING} requests are pending")
                self._waiting.append(request)
                self._some.notify()
        if closed:  # without the lock: the reply is code of the client
            request.refuse(closed)

    def _replace(self, kind: tuple[str, Any, tuple[str, ...]]) -> bool:
        """Remove the last pending request of a kind; return True if there was one."""
        for one in reversed(self._waiting):
            if not one.replaceable:
                return False
            if one.kind == kind:
                self._waiting.remove(one)
                one.answer = REPLACED
                one.done.set()
                return True
        return False

    def pending(self, names: Container[str], first: Container[str] = ()) -> bool:
        """Return True if a request with one of these names is pending, or the first one has a name in `first`.

        Abandoned requests do not count.
        """
        with self._some:
            waiting = [request.what for request in self._waiting if not request.taken]
        return any(what in names for what in waiting) or any(what in first for what in waiting[:1])

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
            pending = [*self._waiting]
            self._waiting.clear()
        for request in pending:
            if request.take():
                request.refuse(reason)


def unknown(what: str) -> CdprError:
    """Return the error of a request with an unknown name."""
    return CdprError(f"'{what[:40]}' is not an allowed request")
