"""Scenarios with one suspicious value each, and the warnings about it."""

from __future__ import annotations

import yaml
from conftest import ROOT

from cdpr.scenario import load_scenario

SCENARIOS = ROOT / "scenarios"
CAROCA = SCENARIOS / "caroca.yaml"
FILES = sorted([*SCENARIOS.glob("*.yaml"), *(SCENARIOS / "robots").glob("*.yaml")])
WEAK = "no tensions within the limits hold the platform's weight"
# Published starts at which the cables cannot hold the platform up, according to the files' first comments.
UNHELD = {SCENARIOS / "thesis.yaml", SCENARIOS / "thesis_ch6.yaml"}
ROBOT = yaml.safe_load((SCENARIOS / "robots" / "caroca.yaml").read_text())
LOW = [{**cable, "frame": [*cable["frame"][:2], 0.0]} for cable in ROBOT["cables"]]  # all from the floor


def warned(changes, path=CAROCA):
    return load_scenario(path, overrides=changes).warnings


def told(rows):
    return [f"{row}".partition(": ")[2] for row in rows]
