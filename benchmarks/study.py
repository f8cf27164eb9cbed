"""A study of 64 runs with one worker and with two: the ratio of the wall times, and what a case costs beyond its loop.

Overhead of a case: wall time of the whole command with one worker (start, checks, workers, logs, tables, report) less
the time in the loops themselves, over the number of cases. Both are worth believing on an idle machine only; the load
before each run is printed. With --short 200 cases of a fifth of a second are run instead, the whole command two at a
time; by an older version in turn where its interpreter is given, and then the ratio of the minima is printed.
Run: python benchmarks/study.py [--json | --short [PYTHON]]
"""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

ROOT = Path(__file__).parent.parent
STUDY = """
scenario: {scenario}
changes: {{simulation.duration: {duration}}}
axes:
  - {{key: simulation.backend, values: [reference, mujoco]}}
  - {{key: controller.kd, values: [20, 40, 60, 80]}}
  - {{key: controller.kp, logspace: {{start: 100, stop: 1600, count: 8}}}}
"""
SHORT = """
scenario: {scenario}
changes: {{simulation.duration: 0.2}}
axes:
  - {{key: simulation.backend, values: [reference, mujoco]}}
  - {{key: controller.kd, values: [20, 30, 40, 60, 80]}}
  - {{key: controller.kp, logspace: {{start: 100, stop: 1600, count: 20}}}}
"""
SHORT_CASES = 200
CASES = 64
DURATION = 60.0  # s, simulated: about half a second each
REPEATS = 3  # alternately, the median counts


def run(study: Path, out: Path, jobs: int, python: str = sys.executable) -> float:
    """Wall time of the command, s."""
    load = os.getloadavg()[0]
    started = perf_counter()
    command = [python, "-P", "-m", "cdpr", "study", str(study), "--out", str(out), "--jobs", str(jobs)]
    subprocess.run(command, check=True, capture_output=True)
    seconds = perf_counter() - started
    print(f"{jobs} at a time: {seconds:.2f} s, load before {load:.2f}", file=sys.stderr)
    return seconds


def in_loops(out: Path) -> float:
    """Time that the runs of a study spent in their loops, s."""
    with (out / "times.csv").open(newline="") as file:
        return sum(float(row["loop_s"]) for row in csv.DictReader(file))


def measure() -> dict[str, float]:
    """All figures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        study = folder / "study.yaml"
        scenario = os.path.relpath(ROOT / "scenarios" / "caroca.yaml", folder)
        study.write_text(STUDY.format(scenario=scenario, duration=DURATION))
        run(study, folder / "warm-up", 2)
        one, two, overhead = [], [], []
        for k in range(REPEATS):
            one.append(run(study, folder / f"one{k}", 1))
            overhead.append((one[-1] - in_loops(folder / f"one{k}")) / CASES)
            two.append(run(study, folder / f"two{k}", 2))
        for table in ("table.csv", "table.parquet"):
            if (folder / "one0" / table).read_bytes() != (folder / "two0" / table).read_bytes():
                raise SystemExit(f"{table} depends on the number of workers")
        return {
            "one_worker_s": median(one),
            "two_workers_s": median(two),
            "speed_up": median(a / b for a, b in zip(one, two, strict=True)),
            "overhead_s_per_case": median(overhead),
        }


def short(others: list[str]) -> None:
    """Print the number of short cases per second."""
    with tempfile.TemporaryDirectory() as name:
        study = Path(name) / "study.yaml"
        study.write_text(SHORT.format(scenario=os.path.relpath(ROOT / "scenarios" / "caroca.yaml", name)))
        times: dict[str, list[float]] = {python: [] for python in (sys.executable, *others)}
        for k in range(REPEATS + 3):
            for python, found in times.items():
                found.append(run(study, Path(name) / f"{k}-{len(python)}-{len(found)}", 2, python))
    best = {python: min(found[1:]) for python, found in times.items()}
    for python, seconds in best.items():
        print(f"{python}: {SHORT_CASES / seconds:.0f} cases a second, {best[python] / best[sys.executable]:.2f} times")


if __name__ == "__main__":
    if "--short" in sys.argv:
        short([word for word in sys.argv[1:] if word != "--short"])
        raise SystemExit
    figures = measure()
    if "--json" in sys.argv:
        print(json.dumps(figures, indent=1))
    else:
        for name, value in figures.items():
            print(f"{name:<22}{value:.3g}")
