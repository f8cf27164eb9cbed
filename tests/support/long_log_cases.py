"""Runs that the tests of long and of thinned logs share, and what makes a run count as long."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.log import reader as reader_module
from cdpr.log import recorder as recorder_module
from cdpr.log import summary as summary_module
from cdpr.log.run import Run
from cdpr.ui.report.plots import histories

CAROCA = ROOT / "scenarios" / "caroca.yaml"
EVENTS = [
    {"type": "cable_jam", "time": 0.503, "cable": "cable_3", "detected_after": 0.1},
    {"type": "limits", "time": 1.002, "max": 60.0},  # no tensions below that hold the platform
    {"type": "limits", "time": 1.057, "max": 650.0},
]
SHORT: dict[str, Any] = {"simulation.duration": 1.505, "events": EVENTS}
THINNED = {**SHORT, "log.step": 0.01}
EVERY = 10
END = 1505 * 0.001  # s


def all_on_disk(patch: pytest.MonkeyPatch) -> None:
    """Every logged run counts as long; no more than a few blocks are read together."""
    for module in (recorder_module, reader_module):
        patch.setattr(module, "IN_MEMORY", 0)
    for module in (summary_module, histories):
        patch.setattr(module, "PIECE", 300)


def simulate_whole(folder: Path) -> Run:
    """A run that stays in memory, with a fault and samples without valid tensions."""
    run = cdpr.simulate(CAROCA, overrides=SHORT, out=folder / "run")
    assert run.summary()["infeasible_steps"] > 0
    assert isinstance(run.rows, np.ndarray)
    return run


def told(run: Run) -> dict[str, Any]:
    """Return the summary without wall-clock times."""
    return {key: value for key, value in run.summary().items() if key != "real_time_factor"}


def log_of(run: Run) -> Path:
    return Path(str(run.folder)) / "log.mcap"
