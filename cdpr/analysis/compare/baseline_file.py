"""Human-readable file of a baseline."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field, ValidationError, model_validator

from cdpr.analysis.compare.baseline import FIELDS, STATE, Baseline
from cdpr.base.checksums import KEY, sealed, unsealed
from cdpr.base.errors import CdprError
from cdpr.base.fields import NonNegative, Section
from cdpr.config.messages import explain

FORMAT = 1


class Content(Section):
    """Content of the file; see `Baseline`. A sample is its time followed by the columns of each field."""

    format: Literal[1]
    scenario: str
    backend: str
    solver: str
    source: str
    changes: list[str]
    versions: dict[str, str]
    machine: dict[str, str]
    status: Literal["finished", "infeasible", "unanswered", "beyond_limits", "touched"]
    count: int = Field(ge=1)
    bounds: dict[str, NonNegative]
    digest: str = Field(pattern="^[0-9a-f]{64}$")
    columns: dict[str, int]
    indices: list[int]
    samples: list[list[float]] = Field(min_length=1)
    scenario_yaml: list[str]

    @model_validator(mode="after")
    def _belong_together(self) -> Content:
        if other := [name for name in self.bounds if name not in STATE]:
            raise ValueError(f"bounds are of {', '.join(STATE)}, not of {other[0]}")
        if list(self.columns) != list(FIELDS) or min(self.columns.values()) < 1:
            raise ValueError(f"columns are those of {', '.join(FIELDS)}, in this order")
        marks = [-1, *self.indices, self.count]
        if len(self.indices) != len(self.samples) or any(a >= b for a, b in pairwise(marks)):
            raise ValueError("the numbers of indices and samples differ")
        if {len(row) for row in self.samples} - {1 + sum(self.columns.values())}:
            raise ValueError("the numbers of columns and values in a sample differ")
        return self


def text_of(baseline: Baseline) -> str:
    """Return the content of a baseline's file."""
    data = {"format": FORMAT, **baseline.__dict__}
    indices, samples, scenario = (data.pop(name) for name in ("indices", "samples", "scenario_yaml"))
    data["columns"] = {name: int(samples[name].shape[1]) for name in FIELDS}
    # One sample per line; repr of a float is exact.
    rows = np.column_stack([samples["time"], *(samples[name] for name in FIELDS)]).tolist()
    lines = ",\n".join(f"  {json.dumps(row)}" for row in rows)
    texts = ",\n".join(f"  {json.dumps(line, ensure_ascii=False)}" for line in scenario.splitlines())
    text = json.dumps(data, indent=1, allow_nan=False)[:-2]
    text += f',\n "indices": {json.dumps(indices.tolist())}'
    text += f',\n "samples": [\n{lines}\n ],\n "scenario_yaml": [\n{texts}\n ]'
    return text + f',\n "{KEY}": "{sealed(json.loads(text + "}"))[KEY]}"\n}}\n'


def read(path: Path) -> Baseline:
    """Return the baseline of a file.

    Raises:
        CdprError: if it cannot be read or is not a baseline.
    """
    try:
        data = unsealed(path.read_bytes())
        content = Content.model_validate(data)
    except OSError as error:
        raise CdprError(f"{path}: cannot be read: {error.strerror or error}") from error
    except ValidationError as error:
        first = explain(error, Content, data)[0]
        raise _none(path, ": ".join([*map(str, first.path), first.text])) from None
    except ValueError as error:
        raise _none(path, str(error)) from None
    columns = np.split(np.array(content.samples), np.cumsum([1, *content.columns.values()])[:-1], axis=1)
    samples = {"time": columns[0][:, 0], **dict(zip(FIELDS, columns[1:], strict=True))}
    fields = content.model_dump(exclude={"format", "columns", "indices", "samples", "scenario_yaml"})
    scenario = "\n".join(content.scenario_yaml) + "\n"
    return Baseline(**fields, scenario_yaml=scenario, indices=np.array(content.indices), samples=samples)


def _none(path: Path, reason: str) -> CdprError:
    return CdprError(f"{path}: cannot be read as a baseline: {reason}; save it again")
