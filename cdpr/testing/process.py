"""Effects of a plugin on its process: output, files and memory."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import io
import os
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path


class OutputCapture:
    """Context that captures all output, of Python and of native code, with `folder` as working folder.

    Attributes:
        output: captured output.
        left: files left in the folder.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._stack = contextlib.ExitStack()
        self.output = ""
        self.left: list[str] = []

    def __enter__(self) -> OutputCapture:
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

    def __exit__(self, *_: object) -> None:
        self.left = sorted(os.listdir(self._folder))
        self._file.seek(0)
        self.output = self._text.getvalue() + self._file.read().decode(errors="replace")
        self._stack.close()


def descriptors() -> int:
    """Return the number of open files of this process (Linux)."""
    return len(os.listdir("/proc/self/fd"))


def threads() -> int:
    """Return the number of threads of this process (Linux), including those of libraries."""
    return len(os.listdir("/proc/self/task"))


class _Heap(ctypes.Structure):
    """glibc's mallinfo2."""

    _fields_ = tuple((name, ctypes.c_size_t) for name in (
        "arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost",
    ))  # fmt: skip


@dataclass(frozen=True)
class MemoryUse:
    """Memory of the process: blocks of Python's allocator and bytes of the system's.

    Both are counted, not estimated from pages, so that a hundred calls reveal a leak. Without glibc, the bytes are
    those of the resident pages.
    """

    blocks: int
    size: int

    @staticmethod
    def now() -> MemoryUse:
        """Return the counts after a garbage collection."""
        gc.collect()
        try:
            count = ctypes.CDLL(None).mallinfo2
        except AttributeError:
            return MemoryUse(sys.getallocatedblocks(), resident_bytes())
        count.restype = _Heap
        heap = count()
        return MemoryUse(sys.getallocatedblocks(), heap.uordblks + heap.hblkhd)

    def more_than(self, before: MemoryUse) -> tuple[int, int]:
        """Return the increase of blocks and bytes."""
        return self.blocks - before.blocks, self.size - before.size


def resident_bytes() -> int:
    """Return the resident memory of this process (Linux), bytes, without freed memory."""
    with contextlib.suppress(AttributeError):  # not glibc
        ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")
