"""Study files that many tests share."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

from conftest import FAULTY, ROOT

SHORT = "simulation.duration: 0.1"
TABLES = ("table.csv", "table.parquet")

# Each of these cases has a fault the first time that it runs: its file does not exist yet.
FAULTS = """
changes: {{simulation.duration: {duration}, controller.type: faulty, controller.kd: 30}}
axes:
  - zip:
      - {{key: controller.kp, range: {{start: 1, stop: {count}, step: 1}}}}
      - {{key: controller.fault, values: [{faults}]}}
      - {{key: controller.once, values: [{files}]}}
"""


def write_study(folder: Path, text: str) -> Path:
    """A study of caroca in runs of a tenth of a second."""
    path = folder / "study.yaml"
    scenario = os.path.relpath(ROOT / "scenarios" / "caroca.yaml", folder)
    path.write_text(f"scenario: {scenario}\nchanges: {{{SHORT}}}\n{text}")
    return path


def faulty_study(folder: Path, faults: list[str], duration: float, keep: str = "none") -> Path:
    """A study whose cases have these faults, once; "none" has none."""
    (folder / "faults").mkdir(exist_ok=True)
    files = ", ".join(str(folder / "faults" / f"{i}") for i in range(len(faults)))
    text = FAULTS.format(duration=duration, count=len(faults), faults=", ".join(faults), files=files)
    path = write_study(folder, "")
    path.write_text(path.read_text().splitlines()[0] + f"\nkeep: {keep}" + text)
    return path


def command(study: Path, out: Path, *options: str) -> list[str]:
    """The command line of a study."""
    return [sys.executable, "-m", "cdpr", "study", str(study), "--out", str(out), "--no-report", *options]


def environment() -> dict[str, str]:
    """One in which the faulty controller is installed."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(FAULTY), str(ROOT)])}


def tables(folder: Path) -> dict[str, bytes]:
    """The tables of a study, to the byte."""
    return {name: (folder / name).read_bytes() for name in TABLES}


def wait_until(true: Callable[[], bool], seconds: float = 120.0) -> None:
    """Wait for something to come true, or fail."""
    deadline = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < deadline
        time.sleep(0.01)
