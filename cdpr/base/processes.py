"""Child processes that end with their parent in any case, even if they hang or are stopped.

A thread in the child that monitors its parent would not suffice: native code may hold the GIL indefinitely.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

from cdpr.base.errors import CdprError

PR_SET_PDEATHSIG = 1  # linux/prctl.h

FEWER = "close other programs, or raise `ulimit -u` and `ulimit -n`"  # remedy if the system has no resources

Result = TypeVar("Result")


def end_with(parent: int) -> None:
    """Let the system kill this process when its parent `parent` ends; Linux only."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it ended before the request
            os._exit(1)


def start(call: Callable[[], Result]) -> Result:
    """Return the result of `call`, which starts a process that will call `end_with`.

    The system monitors the thread that started the child, not its process. Calls from other threads than the main one
    are therefore executed in a permanent thread.

    Raises:
        CdprError: if the system refuses the process.
    """
    try:
        if threading.current_thread() is threading.main_thread():
            return call()
        return _lasting(os.getpid()).submit(call).result()
    except OSError as error:
        reason = error.strerror or error
        place = f"'{error.filename}': {reason}" if error.filename else f"{reason}; {FEWER}"
        raise CdprError(f"cannot start a process: {place}") from error


def ended(code: int) -> str:
    """Return how a process ended, as a phrase that follows its name; `code` is as in `subprocess`."""
    if code >= 0:
        return f"ended with exit code {code}"
    try:
        return f"was ended by {signal.Signals(-code).name}"
    except ValueError:
        return f"was ended by signal {-code}"


@cache
def _lasting(process: int) -> ThreadPoolExecutor:
    """Return the permanent thread of this process; a fork has none of its parent's threads."""
    return ThreadPoolExecutor(1, "cdpr-starts-processes")
