"""Designs that many tests share: quick ones, of the poor box robot that is to become better."""

from __future__ import annotations

import os
from pathlib import Path

from conftest import ROOT

from cdpr.analysis.design import Design, load_design

BOX = """
region: {lower: [-2, -1.5, 0], upper: [2, 1.5, 3], cells: 4}
figures:
  volume: {volume: wrench-feasible, wrench_box: [30, 30, 30, 3, 3, 3]}
  clearance: {least: ifcow}
  width: {extent: x}
vary:
  - {name: arm, keys: [{key: "cables[0].platform[2]"}, {key: "cables[1].platform[2]"}], bounds: [-0.3, 0.3]}
  - name: half width
    keys:
      - {key: "cables[0].frame[0]", factor: -1}
      - {key: "cables[1].frame[0]", factor: -1}
      - {key: "cables[2].frame[0]"}
      - {key: "cables[3].frame[0]"}
    bounds: [1.5, 2.5]
  - {key: platform.mass, bounds: [5, 40]}
"""
ONE = """
goal: {maximise: volume}
constraints:
  - {figure: clearance, at_least: 0.02}
  - {figure: width, at_most: 4.2}
"""
TWO = """
goals: [{maximise: volume}, {minimise: width}]
"""
FILES = ("design.json", "best.yaml", "evaluations.csv")


def write_design(folder: Path, text: str = BOX + ONE, optimizer: str = "evaluations: 40") -> Path:
    """A design of the poor box robot."""
    path = folder / "design.yaml"
    robot = os.path.relpath(ROOT / "scenarios" / "robots" / "poor_box.yaml", folder)
    path.write_text(f"robot: {robot}\n{text}\noptimizer: {{{optimizer}}}\n")
    return path


def design_of(folder: Path, text: str = BOX + ONE, optimizer: str = "evaluations: 40") -> Design:
    """The same, loaded."""
    return load_design(write_design(folder, text, optimizer))


def kept(folder: Path) -> dict[str, bytes]:
    """Return the files of a design, byte by byte, except the ledger, whose order is that of the workers."""
    names = [*FILES, *sorted(f"front/{path.name}" for path in (folder / "front").glob("*"))]
    return {name: (folder / name).read_bytes() for name in names}
