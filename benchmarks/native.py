"""Cost of calling the kernel library from Python, against other ways to call, in one process.

The work is a cross product of no rows, so that only the call remains. Chunks alternate; each figure is the least time
of a chunk, as a ratio to a call of an empty Python function, and in ns. Run: python benchmarks/native.py
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from time import perf_counter

import numpy as np

from cdpr.native import library
from cdpr.native.bind import bind
from cdpr.native.operations import target

CALLS, CHUNKS = 200, 100
EMPTY = np.empty((0, 3))
MATRIX = np.random.default_rng(0).standard_normal((6, 8))


def nothing() -> None:
    """Unit of the ratios."""


def seconds(call: Callable[[], object]) -> float:
    """Time of one call, over one chunk."""
    start = perf_counter()
    for _ in range(CALLS):
        call()
    return (perf_counter() - start) / CALLS


def measure() -> dict[str, float]:
    """Return the least time of each way to call, s."""
    product = np.empty((0, 3))
    call = bind("cross_products", left=EMPTY, right=EMPTY, product=product)
    by_ctypes = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double)(call.operation)
    place = call.place
    ways: dict[str, Callable[[], object]] = {
        "empty Python function": nothing,
        "bound call": call,
        "bound call with the time": lambda: call(0.5),
        "ctypes, bound": lambda: by_ctypes(place, 0.5),
        "bind and call": lambda: bind("cross_products", left=EMPTY, right=EMPTY, product=product)(),
        "pinv of a 6x8 matrix": lambda: np.linalg.pinv(MATRIX),
    }
    times = dict.fromkeys(ways, np.inf)
    for _ in range(CHUNKS):
        for name, way in ways.items():
            times[name] = min(times[name], seconds(way))
    return times


if __name__ == "__main__":
    found = measure()
    print(f"{library.compiler}, {target()}")
    for name, time in found.items():
        print(f"{name:28} {time / found['empty Python function']:9.2f} {time * 1e9:10.0f} ns")
