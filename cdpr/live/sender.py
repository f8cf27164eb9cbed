"""What live links share: a thread of its own that encodes and sends samples, and how requests are handed on."""

from __future__ import annotations

import queue
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from cdpr.live.drive import Request
from cdpr.live.messages import Messages
from cdpr.log.chunk import nanoseconds
from cdpr.log.run import Header
from cdpr.log.topics import Topic
from cdpr.model.robot import Array

ANSWERS = 2.0  # s, that who asks for something waits for it
BACKLOG = 256  # messages that wait for a client; the oldest are dropped
SERVICES = ("pause", "resume", "step", "reset", "stop")


class Sender(ABC):
    """A `cdpr.live.drive.Link`, but for how messages travel.

    Args:
        host, port: where others are met.
        say: called with what is refused.
        parameters: names and values of what others may set beside `paused` and `speed`.

    Attributes:
        where: the address, and who may come there, for people.
        requests: what was asked for and is not done yet.
        parameters: names and values of what others may set.
    """

    where: str

    def __init__(
        self, host: str, port: int, say: Callable[[str], None], parameters: dict[str, Any] | None = None
    ) -> None:
        self.host, self.port = host, port
        self.requests: queue.SimpleQueue[Request] = queue.SimpleQueue()
        self.parameters = {"paused": False, "speed": 1.0, **(parameters or {})}
        self._say = say
        self._shown: deque[tuple[Array, int]] = deque(maxlen=BACKLOG)
        self._some, self._ended = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None

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

    def refused(self, text: str) -> None:
        """Tell who started it, and all others that can be told."""
        self._say(text)

    def close(self) -> None:
        """Send no more, and close all connections."""
        self._ended.set()
        self._some.set()
        if self._thread is not None:
            self._thread.join()
        self._shut()

    def ask(self, request: Request) -> str:
        """Hand a request to the simulation, and return "" or why it was refused."""
        self.requests.put(request)
        late = "the simulation does not answer: it is over, or has not begun"
        return request.answer if request.done.wait(ANSWERS) else late

    def call(self, name: str) -> str:
        """Do what a service of `SERVICES` is for, and return "" or why it was refused."""
        what, values = ("pause", {"paused": False}) if name == "resume" else (name, {})
        answer = self.ask(Request(what, values))
        if not answer and what in ("pause", "step"):
            self.parameters["paused"] = name != "resume"
            self._changed()
        return answer

    def set(self, name: str, value: Any) -> str:
        """Let a parameter have another value, and return "" or why the simulation does not take it."""
        wrong = self._wrong(name, value)
        if wrong:
            self.refused(wrong)
            return wrong
        kinds = {"paused": ("pause", "paused"), "speed": ("speed", "speed")}
        what, key = kinds.get(name, ("set", "value"))
        answer = self.ask(Request(what, {key: value} if what != "set" else {"key": name, "value": value}))
        if not answer:
            self.parameters[name] = value
            self._changed()
        return answer

    def _wrong(self, name: str, value: Any) -> str:
        if name not in self.parameters:
            return f"{name}: there is no such parameter; there are {', '.join(self.parameters)}"
        if isinstance(value, bool) != (name == "paused") or not isinstance(value, bool | int | float):
            return f"{name}: {'true or false' if name == 'paused' else 'a number'} is expected, got {value!r}"
        return ""

    def _send(self) -> None:
        """Send what is shown, if somebody listens."""
        while not self._ended.is_set():
            self._some.wait()
            self._some.clear()
            while self._shown:
                row, sample = self._shown.popleft()
                wanted = self._wanted()
                if any(wanted):
                    time = int(nanoseconds(np.array([sample]), self._step)[0])
                    self._put(time, self._messages.of(row, sample, wanted))

    @abstractmethod
    def _changed(self) -> None:
        """Tell others of parameters that changed."""

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
