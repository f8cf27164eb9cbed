"""Cost of a row of a rollout, in units of one numpy.linalg.pinv of a 6x8 matrix in the same process.

Caroca at 1 kHz for 4 s, on `reference` with the exact QP: cases that differ in gain alone, and in mass, gain and start,
of which a fifth of the samples have cables at a limit and are answered one by one.
Rollouts with one thread, with one for each core, and chunks of pinv calls take turns; each figure is the minimum of all
turns. A row costs what its rollout does, all of it, in CPU time of one core, which other programs change little; the
speed-up is one of wall times, and where the load, printed beside it, is not that of an idle machine it shows nothing.
Set-up is what comes before the first step of a case. Rows of short cases, 4000 of 0.1 s, include everything, from the
file on. Run: python benchmarks/rollout.py [--json]
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

import cdpr

SCENARIO = Path(__file__).parent.parent / "scenarios" / "caroca.yaml"
CASES = 96
TURNS = 6
PINV_CALLS = 300
SAMPLES = 4001
BRIEF = 2  # samples of a case that is all set-up
SHORT, SHORT_CASES, SHORT_TURNS = 101, 4000, 2  # samples of a short case, cases, turns
VARIED: dict[str, Mapping[str, Any]] = {
    "gain": {"controller.kp": {"uniform": [80.0, 200.0]}},
    "mass, gain and start": {
        "robot.platform.mass": {"uniform": [28.0, 32.0]},
        "controller.kp": {"uniform": [80.0, 200.0]},
        "initial.position[0]": {"uniform": [-0.01, 0.01]},
    },
}


def pinv_cost() -> float:
    """Seconds of one pinv, the best of many."""
    matrix, best = np.random.default_rng(1).random((6, 8)), np.inf
    for _ in range(PINV_CALLS):
        start = perf_counter()
        np.linalg.pinv(matrix)
        best = min(best, perf_counter() - start)
    return best


def case_cost(vary: Mapping[str, Any], threads: int, samples: int = SAMPLES, cases: int = CASES) -> tuple[float, float]:
    """Seconds for each case of one rollout: of wall time, and of CPU time."""
    overrides: dict[str, object] = {"simulation.duration": 1e-3 * (samples - 1)}
    if samples < SAMPLES:
        overrides["simulation.ends_early"] = True
    start, cpu = perf_counter(), process_time()
    found = cdpr.rollout(SCENARIO, cases, vary=vary, overrides=overrides, threads=threads)
    seconds = (perf_counter() - start) / cases, (process_time() - cpu) / cases
    if found.counts != {"finished": cases} or found.summary()["strained_share"]:
        raise SystemExit(f"not all cases finished with tensions at all samples: {found}")
    return seconds


def measure() -> dict[str, Any]:
    """All figures."""
    cores = len(os.sched_getaffinity(0))
    figures: dict[str, Any] = {}
    for name, vary in VARIED.items():
        case_cost(vary, cores)  # loads
        pinvs, ones, alls, briefs, loads = [], [], [], [], []
        for _ in range(TURNS):
            loads.append(os.getloadavg()[0])
            pinvs.append(pinv_cost())
            ones.append(case_cost(vary, 1))
            alls.append(case_cost(vary, cores))
            briefs.append(case_cost(vary, 1, BRIEF))
        short = min(case_cost(vary, 1, SHORT, SHORT_CASES)[1] for _ in range(SHORT_TURNS))
        unit, set_up = min(pinvs), min(cpu for _, cpu in briefs)
        row = min(cpu for _, cpu in ones)
        figures[name] = {
            "row": row / unit / SAMPLES,
            "row_without_set_up": (row - set_up) / unit / SAMPLES,
            "set_up": set_up / unit,
            "short_row": short / unit / SHORT,
            "speed_up": min(wall for wall, _ in ones) / min(wall for wall, _ in alls),
            "cores": cores,
            "pinv_us": 1e6 * unit,
            "load": loads,
        }
    return figures


if __name__ == "__main__":
    figures = measure()
    if "--json" in sys.argv:
        print(json.dumps(figures, indent=1))
    else:
        for name, row in figures.items():
            print(f"{name}: {row['row']:.3f} pinv a row, {row['row_without_set_up']:.3f} without set-up, which is")
            print(f"  {row['set_up']:.0f} pinv a case; {row['speed_up']:.2f} times as fast on {row['cores']} cores")
            print(f"  {row['short_row']:.3f} pinv a row of {SHORT_CASES} cases of {1e-3 * (SHORT - 1):g} s")
            loads = ", ".join(f"{load:.1f}" for load in row["load"])
            print(f"  (pinv {row['pinv_us']:.1f} us, load before each turn {loads})")
