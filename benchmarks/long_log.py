"""Cost of a long log: of a step early and late, of a row on disk, and of opening it.

    python benchmarks/long_log.py [SECONDS] [FOLDER]

Caroca at 1 kHz on `reference`, SECONDS (3600) simulated in a fresh process for each figure of processor time; the log
goes to FOLDER (default: a temporary one) and takes 400 to 700 bytes a row. The slope is what a second more costs: to
100 s from 10 s, and beyond.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

EARLY = (10.0, 100.0)  # s
ROUNDS = 3
RUN = """
import os, sys, cdpr
cdpr.simulate("caroca", overrides={"simulation.duration": float(sys.argv[1])}, out=sys.argv[2])
print(sum(os.times()[:2]))
"""
OPEN = """
import sys, time, cdpr
started = time.process_time()
run = cdpr.load_run(sys.argv[1])
print(time.process_time() - started, len(run.rows))
"""


def python(code: str, *arguments: object) -> list[float]:
    """Return the numbers that a program prints."""
    words = [sys.executable, "-c", code, *map(str, arguments)]
    return [float(word) for word in subprocess.run(words, check=True, capture_output=True, text=True).stdout.split()]


def measure(seconds: float, where: str | None) -> dict[str, float]:
    """Return all figures by name."""
    spent: dict[float, float] = {}
    for _ in range(ROUNDS):
        for duration in (*EARLY, seconds):
            with tempfile.TemporaryDirectory(dir=where) as folder:
                out = Path(folder) / "run"
                (taken,) = python(RUN, duration, out)
                spent[duration] = min(taken, spent.get(duration, taken))
                if duration == seconds:
                    opened, rows = min(python(OPEN, out) for _ in range(ROUNDS))
                    size = (out / "log.mcap").stat().st_size / rows
    early = (spent[EARLY[1]] - spent[EARLY[0]]) / (EARLY[1] - EARLY[0])
    late = (spent[seconds] - spent[EARLY[1]]) / (seconds - EARLY[1])
    return {
        "us a step to 100 s": 1e3 * early,
        "us a step beyond": 1e3 * late,
        "ratio": late / early,
        "bytes a row": size,
        "s to open": opened,
    }


if __name__ == "__main__":
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 3600.0
    for name, figure in measure(seconds, sys.argv[2] if len(sys.argv) > 2 else None).items():
        print(f"{name:20} {figure:8.3g}")
