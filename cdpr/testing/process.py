"""What a plugin does to its process: what it prints, leaves in files and keeps."""

from __future__ import annotations

import contextlib
import ctypes
import io
import os
import sys
import tempfile
from pathlib import Path
from types import TracebackType


class Silence:
    """Listens, within `folder` as working folder, to all that is printed, by Python or below it.

    Attributes:
        said: what was printed.
        left: files that were left in the folder.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._stack = contextlib.ExitStack()
        self.said = ""
        self.left: list[str] = []

    def __enter__(self) -> Silence:
        enter = self._stack.enter_context
        self._file = enter(tempfile.TemporaryFile())
        self._text = io.StringIO()
        enter(contextlib.chdir(self._folder))
        for number, stream in ((1, sys.stdout), (2, sys.stderr)):
            stream.flush()
            saved = os.dup(number)
            os.dup2(self._file.fileno(), number)
            self._stack.callback(os.close, saved)
            self._stack.callback(os.dup2, saved, number)
        enter(contextlib.redirect_stdout(self._text))
        enter(contextlib.redirect_stderr(self._text))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.left = sorted(os.listdir(self._folder))
        self._file.seek(0)
        self.said = self._text.getvalue() + self._file.read().decode(errors="replace")
        self._stack.close()


def descriptors() -> int:
    """Open files of this process (Linux)."""
    return len(os.listdir("/proc/self/fd"))


def threads() -> int:
    """Threads of this process (Linux), those of libraries included."""
    return len(os.listdir("/proc/self/task"))


def resident_bytes() -> int:
    """Memory that this process holds (Linux), without what it has freed."""
    with contextlib.suppress(AttributeError):  # not glibc
        ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")
