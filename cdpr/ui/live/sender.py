"""Base class of live links: a thread that encodes and sends samples, and the forwarding of requests."""

from __future__ import annotations

import socket
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from time import monotonic, sleep
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.base.problems import printable, shown
from cdpr.log.chunk import nanoseconds
from cdpr.log.header import Header
from cdpr.log.topics import Topic
from cdpr.model.robot import Array
from cdpr.simulation.requests import Request, Requests
from cdpr.ui.live.messages import Messages
from cdpr.ui.live.received_messages import request_of

ANSWERS = 2.0  # s, time limit of an answer
BACKLOG = 256  # pending samples of a client; the oldest are dropped
MOST_REPORTED = 50  # refusals reported per second; further ones are counted
MOST_TOLD = 500  # characters of each refusal
OFTEN = 1000  # messages per second from all clients that are processed without delay
PAUSE = 0.001  # s of delay before each further message, during which the simulation has the interpreter
SERVICES = ("pause", "resume", "step", "reset", "stop")


class Sender(ABC):
    """Live link without the transport of messages: shows a simulation to clients and receives their requests.

    Args:
        host, port: address of the link.
        say: called with refusals.
        parameters: names and values of settable parameters besides `paused` and `speed`.

    Attributes:
        where: address and access rules for users.
        requests: pending requests, including those from before the simulation.
        parameters: names and values of settable parameters.
        received: number of messages in the current second.

    Raises:
        CdprError: if the host is unknown.
    """

    where: str

    def __init__(
        self, host: str, port: int, say: Callable[[str], None], parameters: dict[str, Any] | None = None
    ) -> None:
        self.host, self.port = _known(host), port
        self.requests = Requests()
        self.parameters: dict[str, Any] = {"paused": False, "speed": 1.0, **(parameters or {})}
        self._say = say
        self._shown: deque[tuple[Array, int, Header]] = deque(maxlen=BACKLOG)
        self._some, self._ended = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None
        self._telling = threading.Lock()
        self._second, self._refused = monotonic(), 0  # refusals in the current second
        self._since, self.received = monotonic(), 0  # the same for messages

    @property
    def address(self) -> str:
        """Address of the link, as in URLs."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    def begin(self, header: Header) -> None:
        """Open all topics and start sending."""
        self._messages, self._step = Messages(header), header.control_step
        self._open(self._messages.topics)
        self._thread = threading.Thread(target=self._send, name="cdpr live", daemon=True)
        self._thread.start()

    def show(self, row: Array, sample: int, header: Header) -> None:
        """Queue a sample for sending, with the run's present header; drop the oldest if too many wait."""
        self._shown.append((row, sample, header))
        self._some.set()

    def changed(self, parameters: Mapping[str, Any]) -> None:
        """Update changed parameters."""
        self.parameters = {**self.parameters, **parameters}

    def refused(self, text: str) -> None:
        """Report a refusal to the user and, if supported, to all clients; count refusals beyond a limit."""
        more = self._more() if monotonic() - self._second >= 1.0 else 0
        if more:
            self._report(f"{more} more requests were rejected")
        with self._telling:
            self._refused += 1
            if self._refused > MOST_REPORTED:
                return
        self._report(printable(text if len(text) <= MOST_TOLD else f"{text[:MOST_TOLD]}..."))

    def warned(self, text: str) -> None:
        """Report an accepted but suspicious request, likewise."""
        self.refused(f"warning: {text}")

    def _more(self) -> int:
        """Start a new second; return the number of unreported refusals of the last one."""
        with self._telling:  # the lock is not held while reporting: senders have their own locks
            more = max(self._refused - MOST_REPORTED, 0)
            self._second, self._refused = monotonic(), 0
        return more

    def _report(self, text: str) -> None:
        """Report a text to the user and, if supported, to all clients."""
        self._say(text)

    def attend(self) -> bool:
        """Count a message and delay floods; return False after the end."""
        if monotonic() - self._since >= 1.0:
            self._since, self.received = monotonic(), 0
        self.received += 1
        if self.received > OFTEN and not self._ended.is_set():
            sleep(PAUSE)
        return not self._ended.is_set()

    def receive(self, topic: str, encoding: str, data: bytes) -> None:
        """Queue the request of a message, or report why it is invalid."""
        try:
            self.requests.put(request_of(topic, encoding, data))
        except CdprError as error:
            self.refused(str(error))

    def close(self) -> None:
        """Stop sending and close all connections."""
        self._ended.set()
        self._some.set()
        if self._thread is not None:
            self._thread.join()
        if more := self._more():
            self._say(f"{more} more requests were rejected")
        self._shut()

    def submit(self, request: Request) -> str:
        """Send a request to the simulation; return "" or the reason of its refusal."""
        try:
            self.requests.put(request, replaceable=False)
        except CdprError as full:
            return str(full)
        if not request.done.wait(ANSWERS) and request.take():
            return "the simulation does not answer, and the request is discarded: it is busy, over, or has not begun"
        while not request.done.wait(ANSWERS):
            if self._ended.is_set():
                return "the run ended before it answered"
        return request.answer

    def call(self, name: str) -> str:
        """Call a service of `SERVICES`; return "" or the reason of its refusal."""
        return self.submit(Request("pause", {"paused": False}) if name == "resume" else Request(name))

    def set(self, name: str, value: Any) -> str:
        """Set a parameter; return "" or the reason of its refusal."""
        request = self.setting(name, value)
        return request if isinstance(request, str) else self.submit(request)

    def setting(self, name: str, value: Any) -> Request | str:
        """Return the request that sets a parameter; if it is invalid, report and return the reason."""
        wrong = self._wrong(name, value)
        if wrong:
            self.refused(wrong)
            return wrong
        if name == "paused":
            return Request("pause", {"paused": value})
        return Request("speed", {"value": value}) if name == "speed" else Request("set", {"key": name, "value": value})

    def _wrong(self, name: str, value: Any) -> str:
        if name not in self.parameters:
            return f"{name or shown(name)}: unknown parameter; allowed: {', '.join(self.parameters)}"
        if isinstance(value, bool) != (name == "paused") or not isinstance(value, bool | int | float):
            return f"{name}: expected {'true or false' if name == 'paused' else 'a number'}, got {shown(value)}"
        return ""

    def _send(self) -> None:
        """Send shown samples that are wanted; after the end, first send the pending ones."""
        ended = False
        while not ended:
            self._some.wait()
            self._some.clear()
            ended = self._ended.is_set()  # read before the samples, so that none is missed
            while self._shown:
                row, sample, header = self._shown.popleft()
                wanted = self._wanted()
                if any(wanted):
                    self._messages.amend(header)
                    time = int(nanoseconds(np.array([sample]), self._step)[0])
                    try:
                        self._put(time, self._messages.of(row, sample, wanted))
                    except CdprError as error:  # no renderer: only the images are missing
                        self._messages.close()
                        self.refused(str(error))
        self._messages.close()

    @abstractmethod
    def _open(self, topics: tuple[Topic, ...]) -> None:
        """Offer topics."""

    @abstractmethod
    def _wanted(self) -> list[bool]:
        """Return for each topic whether it has a subscriber."""

    @abstractmethod
    def _put(self, time: int, messages: Iterator[tuple[int, bytes]]) -> None:
        """Send (topic number, bytes) pairs of one simulation time, ns."""

    @abstractmethod
    def _shut(self) -> None:
        """Close all connections."""


def _known(host: str) -> str:
    """Return a valid host name or address, IPv6 without brackets."""
    name = host.removeprefix("[").removesuffix("]") if host.startswith("[") else host
    try:
        socket.getaddrinfo(name or "?", None)  # "" would mean any host
    except (OSError, UnicodeError) as error:
        text = error.strerror if isinstance(error, OSError) else error
        raise CdprError(
            f"--live-host: expected the name or number of a machine, such as 127.0.0.1, got {shown(host)} ({text})"
        ) from None
    return name
