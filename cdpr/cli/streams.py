"""Where the command line writes: results to stdout, all else, also what foreign code prints, to stderr."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from typing import Any


class _Results(io.FileIO):
    """Once its reader has gone there is nobody to say anything to: the command ends as it would have ended."""

    def write(self, data: Any) -> int:
        """Write, or drop what nobody reads."""
        try:
            return super().write(data)
        except BrokenPipeError:
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
    try:
        out, err = sys.stdout.fileno(), sys.stderr.fileno()
        sys.stdout.flush()
        results = os.dup(out)
    except (AttributeError, OSError, ValueError):  # closed, or a test's
        yield
        return
    os.dup2(err, out)
    sys.stdout = _text(_Results(results, "wb", closefd=False), "surrogateescape", sys.stdout)
    sys.stderr = _text(_Messages(err, "wb", closefd=False), "backslashreplace", sys.stderr)
    try:
        yield
        sys.stdout.flush()
    finally:
        with contextlib.suppress(OSError):  # has been told
            sys.stdout.flush()
        sys.stderr.flush()
        os.dup2(results, out)
        os.close(results)
        sys.stdout, sys.stderr = before


def _text(raw: io.FileIO, errors: str, like: Any) -> io.TextIOWrapper:
    line_buffering = like is sys.stderr or raw.isatty()
    return io.TextIOWrapper(
        io.BufferedWriter(raw), like.encoding, errors, write_through=False, line_buffering=line_buffering
    )
