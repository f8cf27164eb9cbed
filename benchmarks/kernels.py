"""Time of the cable geometry in the kernel library, alone and in lanes.

One process, eight cables: chunks of calls alternate, and the least times count. `eight` is a call for eight problems in
lanes, divided by eight. Run: python benchmarks/kernels.py; CDPR_NATIVE_TARGET chooses the instruction set.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

from cdpr.cables import Pulley
from cdpr.native.bind import LANES, bind
from cdpr.native.operations import target

CALLS, CHUNKS, M = 2000, 400, 8


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


def calls(name: str, given: dict[str, Any], written: dict[str, tuple[int, ...]]) -> Callable[[], object]:
    """Return a run of an operation."""
    call = bind(name, **given, **{key: np.full(shape, np.nan) for key, shape in written.items()})

    def run() -> None:
        for _ in range(CALLS):
            call()

    return run


def lanes(given: dict[str, Any]) -> dict[str, Any]:
    """Return eight of each."""
    return {key: np.repeat(value[..., None], LANES, axis=-1) for key, value in given.items()}


def measure(name: str, given: dict[str, Any], written: dict[str, tuple[int, ...]], label: str) -> None:
    """Print times and their ratio."""
    eights = {key: (*shape, LANES) for key, shape in written.items()}
    one, eight = least(calls(name, given, written), calls(f"{name}_lanes", lanes(given), eights))
    eight /= LANES
    print(f"{label:20} one {1e9 * one:6.1f} ns, eight {1e9 * eight:6.1f} ns; ratio {eight / one:.2f}")


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
    shapes: dict[str, tuple[int, ...]] = {"matrix": (6, M), "length": (M,), "rate": (M,)}
    for label, lines in (("points", anchors), ("pulleys", exits)):
        measure("geometry", {"lines": lines, "state": state}, shapes, f"geometry, {label}")


if __name__ == "__main__":
    main()
