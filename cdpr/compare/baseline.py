"""A run kept in a small file that people can read.

It stands alone: the resolved scenario is in it. The scenario's own file is remembered, too, so that a change of it is
told as what it is. What the platform did and the tensions are kept twice: as a fingerprint of every sample, which tells
whether a later run is the same to the bit, and at a few samples in decimal digits without loss, which tell how far it
is off.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.compare.differences import POSE, QUANTITIES
from cdpr.compare.engines import is_continuous
from cdpr.compare.machine import machine
from cdpr.errors import CdprError, OutputError
from cdpr.log.run import Run
from cdpr.log.run_folder import safe_name
from cdpr.model.robot import Array
from cdpr.scenario import Scenario

FORMAT = 1
SUFFIX = ".baseline.json"
STATE = (*POSE, "velocity", "angular_velocity", "tension")  # the quantities that follow from what is kept
SAMPLES = 25  # kept in digits

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
        samples: every so manyth sample, (S, columns) by field, and their times (S,).
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
    samples: dict[str, Array]

    @property
    def name(self) -> str:
        """Name of its file."""
        return safe_name(f"{self.scenario}_{self.backend}") + SUFFIX


def make(run: Run, scenario: Scenario, changes: Sequence[str], folder: Path) -> Baseline:
    """Make the baseline of a run that is to lie in `folder`."""
    chosen = chosen_samples(len(run.rows))
    samples = {"time": run.time[chosen], **{name: run[name][chosen] for name in FIELDS}}
    bounded = STATE if is_continuous(scenario) else POSE
    return Baseline(
        scenario=run.header.scenario,
        backend=run.header.backend,
        solver=run.header.solver,
        source=Path(os.path.relpath(scenario.source, folder)).as_posix(),
        changes=list(changes),
        scenario_yaml=run.header.scenario_yaml,
        versions=run.header.versions,
        machine=machine(),
        status=run.status,
        count=len(run.rows),
        bounds={name: QUANTITIES[name].allowed(run.header) for name in bounded},
        digest=digest(run),
        samples=samples,
    )


def chosen_samples(count: int) -> Any:
    """Indices of the samples that are kept in digits, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, SAMPLES).round().astype(int)) if count else np.zeros(0, dtype=int)


def digest(run: Run) -> str:
    """SHA-256 of what is kept, of all samples."""
    found = hashlib.sha256()
    for name in FIELDS:
        found.update(np.ascontiguousarray(run[name], dtype="<f8").tobytes())
    return found.hexdigest()


def write(baseline: Baseline, folder: Path) -> Path:
    """Write a baseline into `folder`, made if need be, over an older one of its name."""
    path = folder / baseline.name
    data = {"format": FORMAT, **baseline.__dict__}
    samples = data.pop("samples")
    scenario = data.pop("scenario_yaml")
    # One sample a line; repr of a float loses nothing.
    rows = [[*map(float, row)] for row in np.column_stack([samples["time"], *(samples[name] for name in FIELDS)])]
    data["columns"] = {name: int(samples[name].shape[1]) for name in FIELDS}
    text = json.dumps(data, indent=1, allow_nan=False)[:-2]
    lines = ",\n".join(f"  {json.dumps(row)}" for row in rows)
    texts = ",\n".join(f"  {json.dumps(line, ensure_ascii=False)}" for line in scenario.splitlines())
    text += f',\n "samples": [\n{lines}\n ],\n "scenario_yaml": [\n{texts}\n ]\n}}\n'
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from error
    return path


def read(path: Path) -> Baseline:
    """Read a baseline; CdprError where it cannot be read or is none."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        if data.pop("format") != FORMAT:
            raise ValueError(f"its format is not {FORMAT}: save it anew")
        rows = np.array(data.pop("samples"), dtype=np.float64)
        widths = data.pop("columns")
        ends = np.cumsum([1, *(widths[name] for name in FIELDS)])
        if rows.ndim != 2 or rows.shape[1] != ends[-1]:
            raise ValueError("its samples and columns do not belong together")
        blocks = np.split(rows, ends[:-1], axis=1)
        samples = {"time": blocks[0][:, 0], **dict(zip(FIELDS, blocks[1:], strict=True))}
        scenario = "\n".join(data.pop("scenario_yaml")) + "\n"
        return Baseline(scenario_yaml=scenario, samples=samples, **data)
    except OSError as error:
        raise CdprError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise CdprError(f"{path}: is no baseline that this cdpr can read: {error}") from error
