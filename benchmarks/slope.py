"""Cost of a simulated second in a whole run, with all files, against the cost of its steps in the loop."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from time import perf_counter

import numpy as np
from start import run as command
from step import BACKENDS, Kind, pinv_cost, step_cost

SHORT, LONG = 4.0, 64.0  # s
STEP = 1e-3  # s, of control
REPEATS = 7
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
MATRIX = np.random.default_rng(0).standard_normal((6, 8))


def seconds(words: list[str], folder: str) -> float:
    """Wall time of a command."""
    start = perf_counter()
    subprocess.run([sys.executable, *words], cwd=folder, check=True, capture_output=True, env=os.environ | ONE_THREAD)
    return perf_counter() - start


def slope(*more: str) -> float:
    """Pinvs that a step adds to a run with these options."""
    times: dict[float, list[float]] = {SHORT: [], LONG: []}
    pinvs = []
    for k in range(REPEATS + 1):
        for duration, found in times.items():
            with tempfile.TemporaryDirectory() as folder:
                taken = seconds(command(duration, *more), folder)
            if k:  # the first loads
                found.append(taken)
                pinvs.append(pinv_cost(MATRIX))
    return (min(times[LONG]) - min(times[SHORT])) / ((LONG - SHORT) / STEP) / min(pinvs)


def measure() -> dict[str, dict[str, float]]:
    """All figures, by backend."""
    result = {}
    for backend in BACKENDS:
        step = step_cost(Kind(backend))["ratio"]
        added = {"no report": slope("--backend", backend, "--no-report"), "report": slope("--backend", backend)}
        result[backend] = {"step": step, **{f"slope, {name}": value for name, value in added.items()}}
        result[backend] |= {f"ratio, {name}": value / step for name, value in added.items()}
    return result


if __name__ == "__main__":
    figures = measure()
    if "--json" in sys.argv:
        print(json.dumps(figures, indent=1))
    else:
        for backend, found in figures.items():
            print(f"{backend}: " + ", ".join(f"{name} {value:.2f}" for name, value in found.items()))
