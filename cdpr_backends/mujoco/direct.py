"""Step and clock of MuJoCo as C addresses, for compiled code that does not call Python.

On a fatal error, MuJoCo calls a handler that must not return; without a handler, it terminates the process. The Python
binding sets a handler during each call, and so does `mjb_apply` of MuJoCo's batches. With `mjb_apply`, a C program
calls a function on a model and data and learns whether it failed. The step is called in this way on the existing model
and data, and the batch has no other use. The overhead is a tenth of a step.
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
CONFIG_BYTES = 256  # more than the size of mjBatchConfig, whose first member is the number of threads

# Positions in the words that the operations take (direct.hpp).
APPLY, BATCH, STEP, GET_STATE, MODEL, DATA = range(6)
TIME = int(mujoco.mjtState.mjSTATE_TIME)


class Direct:
    """Step and clock of one model and data.

    Attributes:
        step: operation that performs a step and returns 0, or 1 if MuJoCo failed.
    """

    def __init__(self, model: Any, data: Any, library: Any, batch: int) -> None:
        self._library = library
        words = _Words()
        words.held = model, data, library
        # Not at exit: a thread that has not ended may still perform a step then.
        weakref.finalize(words, library.mjb_deleteBatch, batch).atexit = False
        self._words: NDArray[np.int64] = np.frombuffer(memoryview(words), dtype=np.int64)
        self._words[[APPLY, STEP, GET_STATE]] = [
            _address(function) for function in (library.mjb_apply, library.mj_step, library.mj_getState)
        ]
        self._own = batch, model._address, data._address
        self._words[[BATCH, MODEL, DATA]] = self._own
        self.step: Callable[[], int] = bind("mujoco_step", words=self._words)

    def point_to(self, other: Direct) -> None:
        """Let the operations use the model and data of another one, which must exist as long."""
        self._words[[BATCH, MODEL, DATA]] = other._own

    def clock(self, clock: Array) -> Callable[[], object]:
        """Return the operation that reads the time of MuJoCo into `clock` (1,) [s]."""
        return bind("mujoco_clock", words=self._words, clock=clock, time=TIME)

    def refusal(self) -> str:
        """Return the reason of the failure of the last step."""
        return str(self._library.mjb_error(int(self._words[BATCH]), 0).decode(errors="replace"))


class _Words(ctypes.Array[ctypes.c_int64]):
    """Memory of an array of words, which keeps all objects alive to which the addresses point."""

    _type_, _length_ = ctypes.c_int64, 6
    held: tuple[Any, ...]


def direct(model: Any, data: Any) -> Direct | None:
    """Return the direct access to the step, None if only the binding is available."""
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
    """Return the library that the binding has loaded, None if it lacks a required function."""
    try:
        # Its functions are found through a module that is linked with it, whatever its location and name.
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
    """Return the address of a C function."""
    return int(ctypes.cast(function, ctypes.c_void_p).value or 0)
