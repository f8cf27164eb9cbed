"""What a long command tells on stderr, and what ends it."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from time import monotonic

import click

TERMINAL_SECONDS = 0.2  # between two updates of the line
FILE_SECONDS = 10.0  # between two lines where stderr is no terminal


class Progress:
    """How many cases have ended and the time that is left: one line that changes, or a line now and then."""

    def __init__(self) -> None:
        self._terminal = sys.stderr is not None and sys.stderr.isatty()
        self._every = TERMINAL_SECONDS if self._terminal else FILE_SECONDS
        self._due = monotonic() + self._every
        self._first: tuple[float, int] | None = None  # when a first case had ended here, and how many had by then
        self._known: int | None = None
        self._length = 0

    def checking(self, done: int, total: int) -> None:
        """So many cases are checked."""
        self._show(f"checking case {done + 1} of {total}")

    def running(self, done: int, total: int, counts: Mapping[str, int]) -> None:
        """So many cases have ended, and how."""
        if self._known is None:
            self._known = done
        elif self._first is None:  # from here on the workers have imported and compiled what they need
            self._first = (monotonic(), done)
        parts = [f"{done} of {total} cases"]
        parts += [f"{count} {status}" for status, count in counts.items() if count and status != "finished"]
        if self._first is not None and self._first[1] < done < total:
            then, before = self._first
            parts.append(f"{_span((total - done) * (monotonic() - then) / (done - before))} left")
        self._show(", ".join(parts))

    def say(self, text: str) -> None:
        """Tell something in a line of its own."""
        self.clear()
        click.echo(text, err=True)

    def clear(self) -> None:
        """Take the line away."""
        if self._length:
            click.echo(f"\r{' ' * self._length}\r", err=True, nl=False)
            self._length = 0

    def _show(self, text: str) -> None:
        if monotonic() < self._due:
            return
        self._due = monotonic() + self._every
        if self._terminal:
            click.echo(f"\r{text:<{self._length}}", err=True, nl=False)
            self._length = len(text)
        else:
            click.echo(text, err=True)


class Signals:
    """Whether the system asked for the end, rather than the user."""

    terminated = False

    def handle(self, number: int, frame: object) -> None:
        """End the command as Ctrl-C does."""
        self.terminated = True
        raise KeyboardInterrupt


@contextmanager
def terminating() -> Iterator[Signals]:
    """Let SIGTERM and SIGHUP end a command in the same orderly way as Ctrl-C."""
    signals = Signals()
    before = {number: signal.signal(number, signals.handle) for number in (signal.SIGTERM, signal.SIGHUP)}
    try:
        yield signals
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _span(seconds: float) -> str:
    """A time in the units in which people think of it."""
    whole = round(seconds)
    if whole < 100:
        return f"{whole} s"
    return f"{round(whole / 60)} min" if whole < 6000 else f"{whole / 3600:.1f} h"
