"""A run to be kept, and what of it.

It stands alone: the resolved scenario is in it. The scenario's own file is remembered, too, so that a change of it is
told as what it is. What the platform did and the tensions are kept twice: as a fingerprint of every sample, which tells
whether a later run is the same to the bit, and at a few samples in decimal digits without loss, which tell how far it
is off.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cdpr.compare.differences import POSE, QUANTITIES
from cdpr.compare.engines import is_continuous
from cdpr.compare.machine import machine
from cdpr.log.run import Run
from cdpr.log.run_folder import safe_name
from cdpr.model.robot import Array
from cdpr.scenario import Scenario
from cdpr.scenario.files import seen_from

SUFFIX = ".baseline.json"
STATE = (*POSE, "velocity", "angular_velocity", "tension")  # the quantities that follow from what is kept
SAMPLES = 25  # kept in digits, of a new baseline

# What is kept of a sample. All else in a run follows from these and the scenario.
FIELDS = ("position", "orientation", "velocity", "angular_velocity", "tension")


@dataclass(frozen=True)
class Baseline:
    """A run as it was.

    Attributes:
        scenario_yaml: the resolved scenario, backend and all.
        source: its file, relative to the baseline's folder.
        changes: how it was changed, texts `key=value`.
        bounds: how far a run by other versions or on another machine may be off, by quantity.
        digest: SHA-256 of all samples.
        indices: of the samples that are kept in digits, (S,).
        samples: those, (S, columns) by field, and their times (S,).
    """

    scenario: str
    backend: str
    solver: str
    source: str
    changes: list[str]
    scenario_yaml: str
    versions: dict[str, str]
    machine: dict[str, str]
    status: str
    count: int
    bounds: dict[str, float]
    digest: str
    indices: NDArray[np.int64]
    samples: dict[str, Array]

    @property
    def name(self) -> str:
        """Name of its file."""
        return safe_name(f"{self.scenario}_{self.backend}") + SUFFIX


def make(run: Run, scenario: Scenario, changes: Sequence[str], folder: Path) -> Baseline:
    """Make the baseline of a run that is to lie in `folder`."""
    # The first and the last are among them.
    chosen = np.unique(np.linspace(0, len(run.rows) - 1, SAMPLES).round().astype(np.int64))
    samples = {"time": run.time[chosen], **{name: run[name][chosen] for name in FIELDS}}
    bounded = STATE if is_continuous(scenario) else POSE
    return Baseline(
        scenario=run.header.scenario,
        backend=run.header.backend,
        solver=run.header.solver,
        source=Path(seen_from(folder, scenario.source)).as_posix(),
        changes=list(changes),
        scenario_yaml=run.header.scenario_yaml,
        versions=run.header.versions,
        machine=machine(),
        status=run.status,
        count=len(run.rows),
        bounds={name: QUANTITIES[name].allowed(run) for name in bounded},
        digest=digest(run),
        indices=chosen,
        samples=samples,
    )


def digest(run: Run) -> str:
    """SHA-256 of what is kept, of all samples."""
    found = hashlib.sha256()
    for name in FIELDS:
        found.update(np.ascontiguousarray(run[name], dtype="<f8").tobytes())
    return found.hexdigest()
