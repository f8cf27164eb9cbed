"""Keeps what a library writes past Python off the user's terminal."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

FDS = (1, 2)


@contextmanager
def quiet() -> Iterator[None]:
    """Send everything written to stdout and stderr within to nowhere, also by C code."""
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
    """Empty Python's and C's buffers: what lies there belongs to whoever wrote it."""
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    ctypes.CDLL(None).fflush(None)
