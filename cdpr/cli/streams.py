"""Where the command line writes: results to stdout, all else, also what foreign code prints, to stderr.

It writes text, and nothing that a terminal would obey: names of files, robots, plugins and variables come from
strangers and reach the user by many ways; all of them end here.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
import threading
from collections.abc import Iterable, Iterator
from typing import Any, TextIO, cast

from cdpr.cli.colour import coloured, wanted
from cdpr.hush import is_hushed
from cdpr.problems import printable

# Bytes of a file name that are no UTF-8, as Python keeps them; those below 0xa0 may be controls of a terminal.
FOREIGN_BYTES = re.compile("([\udca0-\udcff]+)")


UNWRITABLE = "cannot write the output"


class Printable:
    """A text stream that escapes all but printable letters, tabs, ends of lines and a `\\r` that ends what is written.

    The last is how the line of progress is written anew; within a text it would write over what stands before it. Where
    the stream takes bytes that are no UTF-8 (`surrogateescape`), they are written as they are, but for controls.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._coloured = wanted(stream)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write and return the number of letters that were given."""
        written = text
        if not text.isprintable():
            raw = self._stream.errors == "surrogateescape"
            parts = FOREIGN_BYTES.split(text) if raw else [text]
            written = "".join(part if i % 2 else _escaped(part) for i, part in enumerate(parts))
        if self._coloured:
            written = coloured(written)
        try:
            self._stream.write(written)
        except UnicodeEncodeError:  # letters that this encoding lacks
            encoding = self._stream.encoding
            self._stream.write(written.encode(encoding, "backslashreplace").decode(encoding))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write all."""
        for line in lines:
            self.write(line)


class _Stdout(Printable):
    """Stdout of a command: for results, which its main thread alone writes, and not while foreign code runs there.

    All else goes to `messages`.
    """

    def __init__(self, results: TextIO, messages: TextIO) -> None:
        super().__init__(results)
        self._messages = messages

    def __getattr__(self, name: str) -> Any:
        return getattr(self._messages if _foreign() else self._stream, name)

    def write(self, text: str) -> int:
        """Write and return the number of letters that were given."""
        return self._messages.write(text) if _foreign() else super().write(text)


def _foreign() -> bool:
    return is_hushed() or threading.current_thread() is not threading.main_thread()


def _escaped(text: str) -> str:
    end = "\r" if text.endswith("\r") else ""
    lines = text.removesuffix(end).split("\n")
    return "\n".join("\t".join(map(printable, line.split("\t"))) for line in lines) + end


@contextlib.contextmanager
def printable_streams() -> Iterator[None]:
    """Write to stdout and stderr through `Printable` until the end of the block or function."""
    before = {name: getattr(sys, name) for name in ("stdout", "stderr")}
    ours = {name: Printable(stream) for name, stream in before.items() if stream is not None}
    for name, stream in ours.items():
        setattr(sys, name, stream)
    try:
        yield
    finally:
        for name, stream in ours.items():
            if getattr(sys, name) is stream:  # not replaced meanwhile, as where its reader has gone
                setattr(sys, name, before[name])


class _Results(io.FileIO):
    """Once its reader has gone there is nobody to say anything to: the command ends as it would have ended.

    Any other failure, such as a full disk, is raised once. What is in the buffers above is dropped after it: it would
    only fail again, when nobody listens, or go to whatever has the number of this descriptor by then.

    Attributes:
        lost: drop what comes.
    """

    lost = False

    def write(self, data: Any) -> int:
        """Write, or drop what nobody reads."""
        if not self.lost:
            try:
                return super().write(data)
            except BrokenPipeError:
                self.lost = True
            except OSError:
                self.lost = True
                raise
        return memoryview(data).nbytes


class _Messages(io.FileIO):
    """No message is worth a run."""

    def write(self, data: Any) -> int:
        """Write if that can be done."""
        try:
            return super().write(data)
        except OSError:
            return memoryview(data).nbytes


@contextlib.contextmanager
def streams() -> Iterator[None]:
    """Let results alone reach stdout inside the block; what native code and processes of ours print goes to stderr.

    File names that are no UTF-8 are written as they are. Streams that are no descriptors stay as they are.
    """
    before = sys.stdout, sys.stderr
    if sys.stderr is None:  # closed: what would go there must not reach stdout
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - as long as the process
    try:
        out, err = sys.stdout.fileno(), sys.stderr.fileno()
        sys.stdout.flush()
        results = os.dup(out)
    except (AttributeError, OSError, ValueError):  # closed, or a test's
        yield
        return
    os.dup2(err, out)
    raw = _Results(results, "wb", closefd=False)
    told = _text(raw, "surrogateescape", sys.stdout)
    messages = _text(_Messages(err, "wb", closefd=False), "backslashreplace", sys.stderr)
    sys.stderr = cast("TextIO", Printable(messages))
    sys.stdout = cast("TextIO", _Stdout(told, sys.stderr))
    try:
        try:
            yield
        except BaseException:  # says how the command ends; that its results are not whole is told besides
            try:
                told.flush()
            except OSError as error:
                sys.stderr.write(f"{UNWRITABLE}: {error}\n")
            raise
        told.flush()
    finally:
        raw.lost = True
        sys.stderr.flush()
        os.dup2(results, out)
        os.close(results)
        sys.stdout, sys.stderr = before


def _text(raw: io.FileIO, errors: str, like: Any) -> TextIO:
    line_buffering = like is sys.stderr or raw.isatty()
    return io.TextIOWrapper(
        io.BufferedWriter(raw), like.encoding, errors, write_through=False, line_buffering=line_buffering
    )
