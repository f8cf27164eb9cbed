"""Locks between processes: of a file or a folder, as long as the process that took them lives, however it ends."""

from __future__ import annotations

import fcntl
import os
import stat
from enum import Enum
from pathlib import Path
from time import monotonic, sleep

RETRY_SECONDS = 0.01


class Lock(Enum):
    """What came of asking for a lock."""

    OURS = "this process has it, until it closes the descriptor"
    ANOTHERS = "another process has it, or another descriptor of this one"
    UNKNOWN = "the file system has no locks: nobody can tell, and nobody is kept away"


def open_to_lock(path: str | Path, flags: int = os.O_RDWR | os.O_CREAT, mode: int = 0o666) -> int:
    """Open a regular file or a folder, which is to be locked; return its descriptor, which no child inherits.

    A link is not followed, and a FIFO not waited for. Raises OSError, also where it is anything else.
    """
    file = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, mode)
    kind = os.fstat(file).st_mode
    if not (stat.S_ISREG(kind) or stat.S_ISDIR(kind)):
        os.close(file)
        raise OSError(0, "is not a regular file", str(path))
    return file


def lock(file: int, wait: float = 0.0) -> Lock:
    """Ask for the lock of an open file, for `wait` seconds while another has it."""
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
