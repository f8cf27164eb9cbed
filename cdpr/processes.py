"""Child processes that end when their parent does, however that ends, also while they hang or are stopped.

A thread of the child that looks for its parent is not enough: native code may hold Python's lock for ever.
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

PR_SET_PDEATHSIG = 1  # linux/prctl.h

Result = TypeVar("Result")


def end_with(parent: int) -> None:
    """Have the system kill this process when the process `parent`, which has just started it, ends; Linux alone can."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it ended before this was asked for
            os._exit(1)


def start(call: Callable[[], Result]) -> Result:
    """Return the result of `call`, which starts a process that will call `end_with`.

    What the system looks at is the end not of the process but of the thread that started the child. So where another
    than the main thread asks, one that lasts does it.
    """
    if threading.current_thread() is threading.main_thread():
        return call()
    return _lasting(os.getpid()).submit(call).result()


def ended(code: int) -> str:
    """Return how a process ended, in words that follow its name, from its return code as `subprocess` has it."""
    if code >= 0:
        return f"ended with exit code {code}"
    try:
        return f"was ended by {signal.Signals(-code).name}"
    except ValueError:
        return f"was ended by signal {-code}"


@cache
def _lasting(process: int) -> ThreadPoolExecutor:
    """A thread of this process: a fork has its number and none of its threads."""
    return ThreadPoolExecutor(1, "cdpr-starts-processes")
