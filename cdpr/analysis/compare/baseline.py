"""Reference data of a run for regression checks.

A baseline is self-contained: it holds the resolved scenario. It also refers to the scenario file, so that a change of
the file is reported as such. The poses, velocities and tensions are stored twice: as a hash of all samples, which
detects any changed bit, and as exact decimal numbers at a few samples, which show the size of a difference.
"""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.compare.differences import POSE, QUANTITIES
from cdpr.analysis.compare.engines import is_continuous
from cdpr.base.files import seen_from
from cdpr.log.run import Run
from cdpr.log.run_folder import safe_name
from cdpr.model.robot import Array
from cdpr.native.operations import targets
from cdpr.scenario import Scenario

SUFFIX = ".baseline.json"
STATE = (*POSE, "velocity", "angular_velocity", "tension")  # quantities computed from FIELDS
SAMPLES = 25  # stored as numbers in a new baseline

# Stored columns. All other data of a run follow from these and the scenario.
FIELDS = ("position", "orientation", "velocity", "angular_velocity", "tension")


@dataclass(frozen=True)
class Baseline:
    """Reference data of one run.

    Attributes:
        scenario_yaml: resolved scenario, including the backend.
        source: scenario file, relative to the folder of the baseline.
        changes: overrides of the scenario, `key=value`.
        bounds: largest allowed difference by quantity, for runs with other versions or on another machine.
        digest: SHA-256 of all samples.
        indices: (S,), indices of the samples stored as numbers.
        samples: these samples: (S, columns) by field, and `time` (S,), s.
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
        """Name of the baseline's file."""
        return file_name(self.scenario, self.backend)


def file_name(scenario: str, backend: str) -> str:
    """Return the name of the file of a scenario's baseline on a backend."""
    return safe_name(f"{scenario}_{backend}") + SUFFIX


def make(run: Run, scenario: Scenario, changes: Sequence[str], folder: Path) -> Baseline:
    """Return the baseline of a run, to be written into `folder`."""
    # includes the first and the last sample
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
    """Return the SHA-256 of the stored columns at all samples."""
    found = hashlib.sha256()
    for name in FIELDS:
        found.update(np.ascontiguousarray(run[name], dtype="<f8").tobytes())
    return found.hexdigest()


def machine() -> dict[str, str]:
    """Return the system, architecture, C library and largest instruction set that the processor supports."""
    return {
        "system": platform.system(),
        "architecture": platform.machine(),
        "libc": "-".join(platform.libc_ver()),
        "processor": targets()[-1],
    }
