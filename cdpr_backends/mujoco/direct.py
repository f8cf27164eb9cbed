"""MuJoCo's step and clock by their C addresses, for compiled code that must not pass through Python.

Where MuJoCo finds an error that it cannot go on from, it calls a handler that must not return; without one it ends the
process. Its binding has a handler of its own during each call. So has `mjb_apply` of its batches, with which a C
program has a function called in a model and data and is told whether it failed: the step is called through that, on
our own model and data; the batch is there for nothing else. It costs a tenth of a step.
"""

from __future__ import annotations

import ctypes
import sys
import weakref
from collections.abc import Callable
from functools import cache
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array
from cdpr.native.bind import bind

NAMES = "mj_step", "mj_getState", "mjb_defaultConfig", "mjb_makeBatch", "mjb_deleteBatch", "mjb_apply", "mjb_error"
CONFIG_BYTES = 256  # more than mjBatchConfig has, whose first member is the number of threads

# Places in the words that the operations take (direct.hpp).
APPLY, BATCH, STEP, GET_STATE, MODEL, DATA = range(6)
TIME = int(mujoco.mjtState.mjSTATE_TIME)


class Direct:
    """The step and the clock of one model and data.

    Attributes:
        step: operation that steps; returns 0, or 1 where MuJoCo gave up.
    """

    def __init__(self, model: Any, data: Any, library: Any, batch: int) -> None:
        self._library = library
        words = _Words()
        words.held = model, data, library
        # Not at exit: a thread that does not end may still be stepping then.
        weakref.finalize(words, library.mjb_deleteBatch, batch).atexit = False
        self._words: NDArray[np.int64] = np.frombuffer(words, dtype=np.int64)
        self._words[[APPLY, STEP, GET_STATE]] = [
            _address(function) for function in (library.mjb_apply, library.mj_step, library.mj_getState)
        ]
        self._words[[BATCH, MODEL, DATA]] = batch, model._address, data._address
        self.step: Callable[[], int] = bind("mujoco_step", words=self._words)

    def clock(self, clock: Array) -> Callable[[], object]:
        """Return the operation that reads MuJoCo's time into `clock` (1,), s."""
        return bind("mujoco_clock", words=self._words, clock=clock, time=TIME)

    def refusal(self) -> str:
        """Why the last step failed."""
        return str(self._library.mjb_error(int(self._words[BATCH]), 0).decode(errors="replace"))


class _Words(ctypes.Array[ctypes.c_int64]):
    """Memory of an array of words: whoever holds such an array holds all to which its addresses point."""

    _type_, _length_ = ctypes.c_int64, 6
    held: tuple[Any, ...]


def direct(model: Any, data: Any) -> Direct | None:
    """Return the way past Python; None where there is none: the binding serves then."""
    library = find_library()
    if library is None or not hasattr(model, "_address") or not hasattr(data, "_address"):
        return None
    config = (ctypes.c_int * (CONFIG_BYTES // 4))()
    library.mjb_defaultConfig(config)
    config[0] = 1
    batch = library.mjb_makeBatch(model._address, 1, config, None, 0)
    return Direct(model, data, library, batch) if batch else None


@cache
def find_library() -> Any:
    """Return the library that the binding has loaded; None where it has not all that is needed."""
    try:
        # Its functions are found through a module that is linked with it, wherever it lies and whatever its name is.
        library: Any = ctypes.CDLL(sys.modules[mujoco.MjModel.__module__].__file__)
        for name in NAMES:
            getattr(library, name)
    except (AttributeError, KeyError, OSError, TypeError):
        return None
    address, number = ctypes.c_void_p, ctypes.c_int
    library.mjb_makeBatch.restype = address
    library.mjb_makeBatch.argtypes = address, number, address, address, number
    library.mjb_defaultConfig.argtypes = (address,)
    library.mjb_deleteBatch.argtypes = (address,)
    library.mjb_error.restype, library.mjb_error.argtypes = ctypes.c_char_p, (address, number)
    return library


def _address(function: Any) -> int:
    """Where a C function stands."""
    return int(ctypes.cast(function, ctypes.c_void_p).value or 0)
