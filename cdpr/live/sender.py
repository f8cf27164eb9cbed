"""What live links share: a thread of its own that encodes and sends samples, and how requests are handed on."""

from __future__ import annotations

import socket
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from time import monotonic, sleep
from typing import Any

import numpy as np

from cdpr.errors import CdprError
from cdpr.live.heard import request_of
from cdpr.live.messages import Messages
from cdpr.live.requests import Request, Requests
from cdpr.log.chunk import nanoseconds
from cdpr.log.run import Header
from cdpr.log.topics import Topic
from cdpr.model.robot import Array
from cdpr.problems import printable, shown

ANSWERS = 2.0  # s, that who asks for something waits for it
BACKLOG = 256  # messages that wait for a client; the oldest are dropped
TOLD = 50  # refusals that are told in a second; of more, how many there were
MOST_TOLD = 500  # characters of each
OFTEN = 1000  # messages in a second from all others that are heard at once; before each more it waits
PAUSE = 0.001  # s: in it the simulation has the interpreter
SERVICES = ("pause", "resume", "step", "reset", "stop")


class Sender(ABC):
    """A `cdpr.live.drive.Link`, but for how messages travel.

    Args:
        host, port: where others are met.
        say: called with what is refused.
        parameters: names and values of what others may set beside `paused` and `speed`.

    Raises CdprError where no machine has that name.

    Attributes:
        where: the address, and who may come there, for people.
        requests: what was asked for and is not done yet.
        parameters: names and values of what others may set.
        heard: how many messages came in this second.
    """

    where: str

    def __init__(
        self, host: str, port: int, say: Callable[[str], None], parameters: dict[str, Any] | None = None
    ) -> None:
        self.host, self.port = _known(host), port
        self.requests = Requests()
        self.parameters: dict[str, Any] = {"paused": False, "speed": 1.0, **(parameters or {})}
        self._say = say
        self._shown: deque[tuple[Array, int]] = deque(maxlen=BACKLOG)
        self._some, self._ended = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None
        self._telling = threading.Lock()
        self._second, self._refused = monotonic(), 0  # in this second so many
        self._since, self.heard = monotonic(), 0  # likewise

    @property
    def address(self) -> str:
        """Where others are met, as URLs have it."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    def begin(self, header: Header) -> None:
        """Open all topics, and send from now on."""
        self._messages, self._step = Messages(header), header.control_step
        self._open(self._messages.topics)
        self._thread = threading.Thread(target=self._send, name="cdpr live", daemon=True)
        self._thread.start()

    def show(self, row: Array, sample: int) -> None:
        """Keep it for who sends; of many that wait the oldest are dropped."""
        self._shown.append((row, sample))
        self._some.set()

    def changed(self, parameters: Mapping[str, Any]) -> None:
        """Take parameters that have other values from now on."""
        self.parameters = {**self.parameters, **parameters}

    def refused(self, text: str) -> None:
        """Tell who started it, and all others that can be told; where there is much to tell, how much."""
        more = self._more() if monotonic() - self._second >= 1.0 else 0
        if more:
            self._tell(f"{more} more requests were refused")
        with self._telling:
            self._refused += 1
            if self._refused > TOLD:
                return
        self._tell(printable(text if len(text) <= MOST_TOLD else f"{text[:MOST_TOLD]}..."))

    def warned(self, text: str) -> None:
        """Tell of what is done, but seldom meant; likewise."""
        self.refused(f"warning: {text}")

    def _more(self) -> int:
        """Begin another second; return how many refusals of the last were not told."""
        with self._telling:  # never while it is told: who sends has locks of its own
            more = max(self._refused - TOLD, 0)
            self._second, self._refused = monotonic(), 0
        return more

    def _tell(self, text: str) -> None:
        """Tell who started it, and all others that can be told."""
        self._say(text)

    def attend(self) -> bool:
        """Count a message; return whether it is heard. Who sends without end is heard as slowly as it takes."""
        if monotonic() - self._since >= 1.0:
            self._since, self.heard = monotonic(), 0
        self.heard += 1
        if self.heard > OFTEN and not self._ended.is_set():
            sleep(PAUSE)
        return not self._ended.is_set()

    def hear(self, topic: str, encoding: str, data: bytes) -> None:
        """Hand on what a message asks for, or tell why it makes no sense."""
        try:
            self.requests.put(request_of(topic, encoding, data))
        except CdprError as error:
            self.refused(str(error))

    def close(self) -> None:
        """Send no more, and close all connections."""
        self._ended.set()
        self._some.set()
        if self._thread is not None:
            self._thread.join()
        if more := self._more():
            self._say(f"{more} more requests were refused")
        self._shut()

    def ask(self, request: Request) -> str:
        """Hand a request to the simulation, and return "" or why it was refused."""
        self.requests.put(request, awaited=True)
        if not request.done.wait(ANSWERS) and request.take():
            return "the simulation does not answer, and does not do it: it is busy, over, or has not begun"
        request.done.wait()
        return request.answer

    def call(self, name: str) -> str:
        """Do what a service of `SERVICES` is for, and return "" or why it was refused."""
        return self.ask(Request("pause", {"paused": False}) if name == "resume" else Request(name))

    def set(self, name: str, value: Any) -> str:
        """Let a parameter have another value, and return "" or why the simulation does not take it."""
        request = self.setting(name, value)
        return request if isinstance(request, str) else self.ask(request)

    def setting(self, name: str, value: Any) -> Request | str:
        """Return the request that lets a parameter have another value, or, having told, why there is none."""
        wrong = self._wrong(name, value)
        if wrong:
            self.refused(wrong)
            return wrong
        if name == "paused":
            return Request("pause", {"paused": value})
        return Request("speed", {"speed": value}) if name == "speed" else Request("set", {"key": name, "value": value})

    def _wrong(self, name: str, value: Any) -> str:
        if name not in self.parameters:
            return f"{name or shown(name)}: there is no such parameter; there are {', '.join(self.parameters)}"
        if isinstance(value, bool) != (name == "paused") or not isinstance(value, bool | int | float):
            return f"{name}: {'true or false' if name == 'paused' else 'a number'} is expected, got {shown(value)}"
        return ""

    def _send(self) -> None:
        """Send what is shown, if somebody listens; after the end, all that was shown before."""
        ended = False
        while not ended:
            self._some.wait()
            self._some.clear()
            ended = self._ended.is_set()  # before the samples, so that none comes in between
            while self._shown:
                row, sample = self._shown.popleft()
                wanted = self._wanted()
                if any(wanted):
                    time = int(nanoseconds(np.array([sample]), self._step)[0])
                    self._put(time, self._messages.of(row, sample, wanted))

    @abstractmethod
    def _open(self, topics: tuple[Topic, ...]) -> None:
        """Offer topics."""

    @abstractmethod
    def _wanted(self) -> list[bool]:
        """Return for each topic whether somebody listens."""

    @abstractmethod
    def _put(self, time: int, messages: Iterator[tuple[int, bytes]]) -> None:
        """Send (number of topic, bytes) each, of one simulation time, ns."""

    @abstractmethod
    def _shut(self) -> None:
        """Close all connections."""


def _known(host: str) -> str:
    """Return the name or number of a machine, IPv6 without brackets."""
    name = host.removeprefix("[").removesuffix("]") if host.startswith("[") else host
    try:
        socket.getaddrinfo(name or "?", None)  # "" would be any
    except (OSError, UnicodeError) as error:
        text = error.strerror if isinstance(error, OSError) else error
        raise CdprError(
            f"--live-host: the name or number of a machine, such as 127.0.0.1, is expected, got {shown(host)} ({text})"
        ) from None
    return name
