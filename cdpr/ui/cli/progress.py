"""Progress display of long commands on stderr, and signals that end them."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from time import monotonic
from types import MappingProxyType

import click

from cdpr.base.errors import CdprError, ExitCode
from cdpr.base.interrupts import STOPPING, WAITING
from cdpr.ui.cli.colour import bar

TERMINAL_SECONDS = 0.2  # s between two updates of the line
FILE_SECONDS = 10.0  # s between two lines if stderr is no terminal

NOTHING: Mapping[str, int] = MappingProxyType({})


class Progress:
    """Progress display with the remaining time: one updated line on a terminal, occasional lines in a file.

    Args:
        unit: counted unit, such as "cases"; "" displays per cent.
        at_once: display the first call, too, for commands with a long start.
    """

    def __init__(self, unit: str = "", *, at_once: bool = False) -> None:
        self._unit = unit
        self._terminal = sys.stderr is not None and sys.stderr.isatty()
        self._every = TERMINAL_SECONDS if self._terminal else FILE_SECONDS
        self._due = monotonic() + (0.0 if at_once else self._every)
        self._first: tuple[float, int] | None = None  # time and count of the first progress
        self._known: int | None = None
        self._length = 0

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *error: object) -> None:
        self._clear()

    def __call__(self, done: int, total: int, counts: Mapping[str, int] = NOTHING) -> None:
        """Display the progress; `counts` are numbers of finished cases by status."""
        now = monotonic()
        if self._known is None:
            self._known = done
        elif self._first is None and done > self._known:  # imports are complete from here on
            self._first = (now, done)
        if now < self._due:
            return
        self._due = now + self._every
        parts = [f"{done} of {total} {self._unit}" if self._unit else f"{done / total:.0%}"]
        parts += [f"{count} {status}" for status, count in counts.items() if count and status != "finished"]
        if self._first is not None and self._first[1] < done < total:
            then, before = self._first
            parts.append(f"{_span((total - done) * (now - then) / (done - before))} left")
        text = ", ".join(parts)
        share = done / total if total else 1.0
        self._show(f"{bar(share, sys.stderr.encoding)} {text}" if self._terminal else text)

    def show(self, text: str) -> None:
        """Display a text at once, on a terminal only."""
        if self._terminal:
            self._show(text)

    def print_line(self, text: str) -> None:
        """Print a separate line."""
        self._clear()
        click.echo(text, err=True)

    def _show(self, text: str) -> None:
        if self._terminal:  # output of others then starts at the beginning of the line
            click.echo(f"{text:<{self._length}}\r", err=True, nl=False)
            self._length = len(text)
        else:
            click.echo(text, err=True)

    def _clear(self) -> None:
        if self._length:
            click.echo(f"{' ' * self._length}\r", err=True, nl=False)
            self._length = 0


class Signals:
    """Received signals.

    Attributes:
        pending: True after a signal.
        received: number of signals.
        terminated: True if the system sent it, not the user.
        raised: True if one was raised as an exception.
        wait: store the next signal for the command to check. The one after it ends the command at once, as does any
            signal while the command waits for another process.
    """

    pending = False
    received = 0
    terminated = False
    raised = False
    wait = False

    def handle(self, number: int, frame: object) -> None:
        """End the command like Ctrl-C, or store the signal for it."""
        self.terminated = number != signal.SIGINT
        self.pending = True
        self.received += 1
        if not self.wait or WAITING.here:
            self.raised = True
            raise KeyboardInterrupt
        self.wait = False

    @property
    def exit_code(self) -> ExitCode:
        """Exit code of a command ended by a signal."""
        return ExitCode.TERMINATED if self.terminated else ExitCode.INTERRUPTED


@contextmanager
def terminating() -> Iterator[Signals]:
    """Let SIGTERM and SIGHUP end a command in the same orderly way as Ctrl-C, with their own exit codes."""
    signals = Signals()
    handled = [number for number in STOPPING if signal.getsignal(number) != signal.SIG_IGN]  # not under nohup
    before = {number: signal.signal(number, signals.handle) for number in handled}
    try:
        yield signals
    except KeyboardInterrupt:
        raise click.exceptions.Exit(signals.exit_code) from None
    except (CdprError, click.ClickException, click.exceptions.Exit, OSError):
        raise
    except Exception:
        if not signals.raised:
            raise
        # exception that a library or an import raised because of the interrupt
        raise click.exceptions.Exit(signals.exit_code) from None
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _span(seconds: float) -> str:
    """Return a duration in a suitable unit."""
    whole = round(seconds)
    if whole < 100:
        return f"{whole} s"
    return f"{round(whole / 60)} min" if whole < 6000 else f"{whole / 3600:.1f} h"
