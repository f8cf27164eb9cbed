"""The latest of everything that windows show; each takes at its own pace what it has not yet seen.

A message replaces the one of its kind that was there, so a window that is slow, or comes late, gets the newest alone,
and what waits for it is bounded however slow it is. Curves, which grow, are cut out for each window from where it is.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Iterator, Mapping
from threading import Condition
from typing import Any

from cdpr.gui.curves import Curves

Message = Mapping[str, Any]

# In this order: each is drawn into what stands before it.
KINDS = ("hello", "form", "scene", "status", "frame")
MOST_WAITING = 50  # messages of its own that a window has not taken yet: the oldest are dropped


def encoded(message: Message) -> str:
    """Return a message as it is sent; ValueError where it holds a number that JSON has not."""
    return json.dumps(message, separators=(",", ":"), allow_nan=False)


class Posted:
    """A message on the board, encoded when the first window takes it."""

    def __init__(self, number: int, message: Message) -> None:
        self.number, self.message = number, message
        self._text: str | None = None

    @property
    def text(self) -> str:
        """The message as it is sent."""
        if self._text is None:
            self._text = encoded(self.message)
        return self._text


class Board:
    """What is to be shown; threads put it here, and windows wait for it."""

    def __init__(self) -> None:
        self.changed = Condition()
        self.curves = Curves()
        self._latest: dict[str, Posted] = {}
        self._count = 0
        self._readers: list[Reader] = []

    def put(self, message: Message) -> None:
        """Show a message in place of the last one of its kind; one of no such kind goes to every window."""
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
        """The last message of a kind."""
        with self.changed:
            posted = self._latest.get(kind)
        return None if posted is None else posted.message

    def join(self) -> Reader:
        """Return what takes messages for another window."""
        reader = Reader(self)
        with self.changed:
            self._readers.append(reader)
        return reader

    def leave(self, reader: Reader) -> None:
        """Forget a window, and wake whoever waits for its messages."""
        with self.changed:
            reader.gone = True
            self._readers.remove(reader)
            self.changed.notify_all()


class Reader:
    """What one window has seen.

    Attributes:
        own: messages for it alone.
        gone: it takes no more.
    """

    def __init__(self, board: Board) -> None:
        self.own: deque[Message] = deque(maxlen=MOST_WAITING)
        self.gone = False
        self._board = board
        self._seen: dict[str, int] = {}
        self._mark = board.curves.start()

    def tell(self, message: Message) -> None:
        """Let this window alone have a message."""
        with self._board.changed:
            self.own.append(message)
            self._board.changed.notify_all()

    def __iter__(self) -> Iterator[str]:
        """Yield texts to be sent, waiting for them, until the window is gone."""
        board = self._board
        while not self.gone:
            texts: list[str] = []
            with board.changed:
                fresh = [board._latest[kind] for kind in KINDS if self._is_new(kind)]
                curves, self._mark = board.curves.since(self._mark)
                own = list(self.own)
                self.own.clear()
                if not (fresh or curves or own):
                    board.changed.wait()
                    continue
                self._seen |= {posted.message["kind"]: posted.number for posted in fresh}
            texts = [posted.text for posted in fresh]
            texts += [encoded(message) for message in (*curves, *own)]
            yield from texts

    def _is_new(self, kind: str) -> bool:
        posted = self._board._latest.get(kind)
        return posted is not None and posted.number > self._seen.get(kind, 0)
