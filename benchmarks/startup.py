"""CPU seconds (user and system, of the whole process) of the command line: help, a run, a run with its report.

Each figure is the median of several fresh processes after one that is not counted; `compile` is a run with an empty
cache, `cached` the same with a warm one. Run: python benchmarks/startup.py [--json]
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

ROOT = Path(__file__).parent.parent
RUN = ["run", str(ROOT / "scenarios" / "caroca.yaml"), "--set", "simulation.duration=2"]
COUNT = 5


def cpu(arguments: list[str], folder: str, env: dict[str, str] | None = None) -> float:
    """CPU seconds of one process."""

    def used() -> float:
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    before = used()
    subprocess.run(
        [sys.executable, "-m", "cdpr", *arguments],
        cwd=folder,
        env={**os.environ, **(env or {})},
        check=True,
        capture_output=True,
    )
    return used() - before


def typical(arguments: list[str], folder: str) -> float:
    """Median of COUNT processes after a warm-up."""
    return median([cpu(arguments, folder) for _ in range(COUNT + 1)][1:])


def measure() -> dict[str, float]:
    """All figures, s."""
    with tempfile.TemporaryDirectory() as folder:
        return {
            "help": typical(["--help"], folder),
            "run": typical([*RUN, "--no-report"], folder),
            "run_report": typical(RUN, folder),
            "compile": cpu([*RUN, "--no-report"], folder, {"NUMBA_CACHE_DIR": f"{folder}/cache"}),
            "cached": cpu([*RUN, "--no-report"], folder, {"NUMBA_CACHE_DIR": f"{folder}/cache"}),
        }


if __name__ == "__main__":
    figures = measure()
    if "--json" in sys.argv:
        print(json.dumps(figures, indent=2))
    else:
        for name, seconds in figures.items():
            print(f"{name:<12}{seconds:.3f} s CPU")
