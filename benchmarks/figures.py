"""Measure every figure that docs/figures.md quotes and write them to benchmarks/figures.json.

Run: python benchmarks/figures.py && python docs/update_readme.py
"""

from __future__ import annotations

import json
from pathlib import Path

import distribute
import rollout
import start
import step

FILE = Path(__file__).parent / "figures.json"


def rounded(value: object) -> object:
    """Three digits: more than the noise of the machine allows."""
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    return float(f"{value:.3g}") if isinstance(value, float) else value


if __name__ == "__main__":
    parts = {"step": step, "distribute": distribute, "rollout": rollout, "startup": start}
    figures = rounded({name: part.measure() for name, part in parts.items()})
    FILE.write_text(json.dumps(figures, indent=2) + "\n")
    print(FILE.read_text())
