"""Locks between processes on files or folders, held until the process releases them or ends in any way."""

from __future__ import annotations

import fcntl
import os
import stat
from enum import Enum
from pathlib import Path
from time import monotonic, sleep

RETRY_SECONDS = 0.01


class Lock(Enum):
    """Result of a lock request."""

    OURS = "held by this process until it closes the descriptor"
    ANOTHERS = "held by another process, or by another descriptor of this process"
    UNKNOWN = "the file system does not support locks"


def open_to_lock(path: str | Path, flags: int = os.O_RDWR | os.O_CREAT, mode: int = 0o666) -> int:
    """Open a regular file or a folder for locking; return its descriptor, which child processes do not inherit.

    Links are not followed, and FIFOs do not block.

    Raises:
        OSError: if it cannot be opened or is anything else.
    """
    file = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, mode)
    kind = os.fstat(file).st_mode
    if not (stat.S_ISREG(kind) or stat.S_ISDIR(kind)):
        os.close(file)
        raise OSError(0, "is not a regular file", str(path))
    return file


def lock(file: int, wait: float = 0.0) -> Lock:
    """Request the lock of an open file, waiting up to `wait` seconds."""
    end = monotonic() + wait
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return Lock.OURS
        except BlockingIOError:
            if monotonic() >= end:
                return Lock.ANOTHERS
            sleep(RETRY_SECONDS)
        except OSError:
            return Lock.UNKNOWN
