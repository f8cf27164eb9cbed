"""Broadcast of the latest GUI data to all connected windows.

A message replaces the previous one of its kind. Slow or late windows get only the newest, so that the backlog is
bounded. Curves grow; each window receives the part it lacks.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Iterator, Mapping
from threading import Condition
from typing import Any

from cdpr.ui.gui.curves import Curves

Message = Mapping[str, Any]

# Order matters: each kind is drawn into the previous ones.
KINDS = ("hello", "form", "scene", "status", "frame", "images")
MOST_WAITING = 50  # pending messages of one window; beyond, the oldest are dropped


def encoded(message: Message) -> str:
    """Return a message as JSON.

    Raises:
        ValueError: if it contains a number that is not finite.
    """
    return json.dumps(message, separators=(",", ":"), allow_nan=False)


class Posted:
    """Latest message of a kind, encoded when the first window takes it."""

    def __init__(self, number: int, message: Message) -> None:
        self.number, self.message = number, message
        self._text: str | None = None

    @property
    def text(self) -> str:
        """The message as JSON."""
        if self._text is None:
            self._text = encoded(self.message)
        return self._text


class Broadcast:
    """Latest messages: threads put them here, and windows wait for them."""

    def __init__(self) -> None:
        self.changed = Condition()
        self.curves = Curves()
        self._latest: dict[str, Posted] = {}
        self._count = 0
        self._readers: list[Reader] = []

    def put(self, message: Message) -> None:
        """Publish a message: it replaces the last one of its kind; messages of other kinds go to every window."""
        with self.changed:
            kind = message["kind"]
            if kind in KINDS:
                self._count += 1
                self._latest[kind] = Posted(self._count, message)
            else:
                for reader in self._readers:
                    reader.own.append(message)
            self.changed.notify_all()

    def latest(self, kind: str) -> Message | None:
        """Return the last message of a kind, or None."""
        with self.changed:
            posted = self._latest.get(kind)
        return None if posted is None else posted.message

    def join(self) -> Reader:
        """Return a reader for a new window."""
        reader = Reader(self)
        with self.changed:
            self._readers.append(reader)
        return reader

    def leave(self, reader: Reader) -> None:
        """Remove a window's reader, and wake the thread that waits for its messages."""
        with self.changed:
            reader.gone = True
            self._readers.remove(reader)
            self.changed.notify_all()


class Reader:
    """Messages that a window has not yet received.

    Attributes:
        own: messages for this window only.
        gone: True once the window is closed.
    """

    def __init__(self, broadcast: Broadcast) -> None:
        self.own: deque[Message] = deque(maxlen=MOST_WAITING)
        self.gone = False
        self._broadcast = broadcast
        self._seen: dict[str, int] = {}
        self._mark = broadcast.curves.start()

    def send(self, message: Message) -> None:
        """Send a message to this window only."""
        with self._broadcast.changed:
            self.own.append(message)
            self._broadcast.changed.notify_all()

    def __iter__(self) -> Iterator[str]:
        """Yield messages as JSON, waiting for new ones, until the window is closed."""
        broadcast = self._broadcast
        while not self.gone:
            texts: list[str] = []
            with broadcast.changed:
                fresh = [broadcast._latest[kind] for kind in KINDS if self._is_new(kind)]
                curves, self._mark = broadcast.curves.since(self._mark)
                own = list(self.own)
                self.own.clear()
                if not (fresh or curves or own):
                    broadcast.changed.wait()
                    continue
                self._seen |= {posted.message["kind"]: posted.number for posted in fresh}
            texts = [posted.text for posted in fresh]
            texts += [encoded(message) for message in (*curves, *own)]
            yield from texts

    def _is_new(self, kind: str) -> bool:
        posted = self._broadcast._latest.get(kind)
        return posted is not None and posted.number > self._seen.get(kind, 0)
