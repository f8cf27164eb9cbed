"""Suppression of output that libraries write to the terminal from C code."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

FDS = (1, 2)


@contextmanager
def quiet() -> Iterator[None]:
    """Discard all output to stdout and stderr in the context, including output of C code."""
    _flush()
    kept = [os.dup(fd) for fd in FDS]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for fd in FDS:
        os.dup2(nowhere, fd)
    os.close(nowhere)
    try:
        yield
    finally:
        _flush()
        for fd, copy in zip(FDS, kept, strict=True):
            os.dup2(copy, fd)
            os.close(copy)


def _flush() -> None:
    """Flush the buffers of Python and C, whose content belongs to earlier writers."""
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    ctypes.CDLL(None).fflush(None)
