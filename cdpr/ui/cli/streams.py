"""Output streams of the command line: results to stdout, everything else, including foreign output, to stderr.

Control characters are never written: names of files, robots, plugins and variables come from untrusted sources and
reach the user in many ways, all through these streams.
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

from cdpr.base.problems import printable
from cdpr.base.redirect_output import is_redirected, open_closed_streams
from cdpr.ui.cli.colour import coloured, wanted

# Undecodable bytes of file names, as represented by Python; those below 0xa0 may be control characters.
FOREIGN_BYTES = re.compile("([\udca0-\udcff]+)")


UNWRITABLE = "cannot write the output"


class Printable:
    r"""Text stream that escapes all but printable characters, tabs, line ends and a final `\\r`.

    The final `\\r` lets the progress line be rewritten; inside a text it would overwrite the preceding characters. If
    the stream accepts undecodable bytes (`surrogateescape`), they are written unchanged, except for control characters.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._coloured = wanted(stream)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text and return its number of characters."""
        written = text
        if not text.isprintable():
            raw = self._stream.errors == "surrogateescape"
            parts = FOREIGN_BYTES.split(text) if raw else [text]
            written = "".join(part if i % 2 else _escaped(part) for i, part in enumerate(parts))
        if self._coloured:
            written = coloured(written)
        try:
            self._stream.write(written)
        except UnicodeEncodeError:  # characters missing in this encoding
            encoding = self._stream.encoding
            self._stream.write(written.encode(encoding, "backslashreplace").decode(encoding))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write all lines."""
        for line in lines:
            self.write(line)


class _Stdout(Printable):
    """Stdout of a command for its results, written only by the main thread and not by foreign code.

    All other output goes to `messages`.
    """

    def __init__(self, results: TextIO, messages: TextIO) -> None:
        super().__init__(results)
        self._messages = messages

    def __getattr__(self, name: str) -> Any:
        return getattr(self._messages if _foreign() else self._stream, name)

    def write(self, text: str) -> int:
        """Write a text and return its number of characters."""
        return self._messages.write(text) if _foreign() else super().write(text)


def _foreign() -> bool:
    return is_redirected() or threading.current_thread() is not threading.main_thread()


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
            if getattr(sys, name) is stream:  # not replaced in the meantime, such as after a broken pipe
                setattr(sys, name, before[name])


class _Results(io.FileIO):
    """File of results: after its reader has gone, output is dropped, and the command ends normally.

    Any other failure, such as a full disk, is raised once. Buffered data is then dropped: it would fail again
    unnoticed, or go to another file that reuses the descriptor.

    Attributes:
        lost: drop all data.
    """

    lost = False

    def write(self, data: Any) -> int:
        """Write the data, or drop it if nobody reads."""
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
    """File of messages; its failures are ignored."""

    def write(self, data: Any) -> int:
        """Write the data if possible."""
        try:
            return super().write(data)
        except OSError:
            return memoryview(data).nbytes


@contextlib.contextmanager
def streams() -> Iterator[None]:
    """Let only results reach stdout inside the block; output of native code and child processes goes to stderr.

    Undecodable file names are written unchanged. Streams without descriptors are not changed.
    """
    open_closed_streams()
    before = sys.stdout, sys.stderr
    if sys.stderr is None:  # closed: its messages must not reach stdout
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  - open until the process ends
    try:
        out, err = sys.stdout.fileno(), sys.stderr.fileno()
        sys.stdout.flush()
        results = os.dup(out)
    except (AttributeError, OSError, ValueError):  # closed, or replaced by a test
        yield
        return
    os.dup2(err, out)
    raw = _Results(results, "wb", closefd=False)
    text = _text(raw, "surrogateescape", sys.stdout)
    messages = _text(_Messages(err, "wb", closefd=False), "backslashreplace", sys.stderr)
    sys.stderr = cast("TextIO", Printable(messages))
    sys.stdout = cast("TextIO", _Stdout(text, sys.stderr))
    try:
        try:
            yield
        except BaseException:  # the exception defines the exit; incomplete results are reported in addition
            try:
                text.flush()
            except OSError as error:
                sys.stderr.write(f"{UNWRITABLE}: {error}\n")
            raise
        text.flush()
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
