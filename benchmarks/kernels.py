"""Time of kernels of the C++ library, against the numba kernels that they replace.

One process, 6x8: chunks of calls from compiled loops alternate, and the ratio is that of the least times. `eight` is a
call for eight problems in lanes, divided by eight. Run: python benchmarks/kernels.py; CDPR_NATIVE_TARGET chooses the
instruction set.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

from cdpr.cables import Pulley
from cdpr.cables.lines import rows
from cdpr.mechanics.geometry import cable_geometry
from cdpr.model.address import c_caller
from cdpr.model.jit import kernel
from cdpr.model.kinds import NUMBER, WHOLE
from cdpr.native.bind import LANES, bind
from cdpr.native.operations import operations, target

CALLS, CHUNKS, M = 2000, 400, 8

run_native = c_caller(WHOLE(WHOLE, NUMBER))


@kernel
def repeat_native(operation: int, place: int, calls: int) -> None:
    """Run an operation of the library."""
    for _ in range(calls):
        run_native(operation, place, 0.0)


@kernel
def repeat_geometry(lines: Any, state: Any, W: Any, length: Any, rate: Any, calls: int) -> None:
    """Run numba's geometry."""
    for _ in range(calls):
        cable_geometry(lines, state, W, length, rate)


def least(*runs: Callable[[], object]) -> list[float]:
    """Return the least time of a call, s, of each."""
    best = [np.inf] * len(runs)
    for run in runs:
        run()
    for _ in range(CHUNKS):
        for k, run in enumerate(runs):
            started = perf_counter()
            run()
            best[k] = min(best[k], perf_counter() - started)
    return [seconds / CALLS for seconds in best]


def native(
    name: str, given: dict[str, Any], written: dict[str, tuple[int, ...]], **values: float
) -> Callable[[], object]:
    """Return a run of an operation."""
    call = bind(name, **given, **values, **{key: np.full(shape, np.nan) for key, shape in written.items()})
    return lambda: (repeat_native(call.operation, call.place, CALLS), call)


def lanes(given: dict[str, Any]) -> dict[str, Any]:
    """Return eight of each."""
    return {key: np.repeat(value[..., None], LANES, axis=-1) for key, value in given.items()}


def compare(
    name: str,
    ours: Callable[[], object],
    given: dict[str, Any],
    written: dict[str, tuple[int, ...]],
    label: str = "",
    **values: float,
) -> None:
    """Print times and ratios."""
    if f"{name}_lanes" not in operations():
        numba, one = least(ours, native(name, given, written, **values))
        print(f"{label or name:28} numba {1e9 * numba:6.1f} ns, one {1e9 * one:6.1f} ns; ratio {one / numba:.2f}")
        return
    eights = {key: (*shape, LANES) for key, shape in written.items()}
    numba, one, eight = least(
        ours, native(name, given, written, **values), native(f"{name}_lanes", lanes(given), eights, **values)
    )
    eight /= LANES
    times = f"numba {1e9 * numba:6.1f} ns, one {1e9 * one:6.1f} ns, eight {1e9 * eight:6.1f} ns"
    print(f"{label or name:28} {times}; ratios {one / numba:.2f} and {eight / numba:.2f}")


def main() -> None:
    """Print a line for each kernel."""
    rng = np.random.default_rng(1)
    corners = np.array([[x, y, z] for x in (-2, 2) for y in (-2, 2) for z in (0, 4)], dtype=float)
    anchors = np.concatenate([corners, rng.uniform(-0.3, 0.3, (M, 3))], axis=1)
    q = np.array([1.0, 0.1, -0.05, 0.08])
    state = np.concatenate([[0.1, 0.2, 1.9], q / np.linalg.norm(q), rng.normal(size=6)])
    pulley = Pulley(type="pulley", radius=0.05)
    exits = np.concatenate([anchors, np.ones((M, 1)), np.tile(pulley.numbers(), (M, 1))], axis=1)
    print(f"instruction set {target()}")
    W, length, rate = np.empty((6, M)), np.empty(M), np.empty(M)
    shapes: dict[str, tuple[int, ...]] = {"matrix": (6, M), "length": (M,), "rate": (M,)}
    for label, ours, theirs in (("points", anchors, anchors), ("pulleys", rows(anchors, [pulley] * M), exits)):
        run = lambda ours=ours: repeat_geometry(ours, state, W, length, rate, CALLS)  # noqa: E731
        compare("geometry", run, {"lines": theirs, "state": state}, shapes, f"geometry, {label}")


if __name__ == "__main__":
    main()
