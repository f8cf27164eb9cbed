"""Study files that many tests share."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from conftest import FAULTY, ROOT

SHORT = "simulation.duration: 0.1"
TABLES = ("table.csv", "table.parquet")


def write_study(folder: Path, text: str) -> Path:
    """A study of caroca in runs of a tenth of a second."""
    path = folder / "study.yaml"
    scenario = os.path.relpath(ROOT / "scenarios" / "caroca.yaml", folder)
    path.write_text(f"scenario: {scenario}\nchanges: {{{SHORT}}}\n{text}")
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
