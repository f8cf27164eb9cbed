"""run.json: status and summary of a run. The file is always valid; its status is "running" until the run has ended."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.base.checksums import check_type, checksum, sealed, unsealed
from cdpr.base.errors import LogError
from cdpr.log.event import Event
from cdpr.log.files import replace
from cdpr.log.header import Header
from cdpr.log.run import Run

NAME = "run.json"
WITHOUT = "without that file the log still loads"


@dataclass(frozen=True)
class LogOf:
    """Identity of the log that belongs to a run.json.

    Attributes:
        scenario: checksum of the resolved scenario in its header.
        rows: number of its rows.
        last_row: checksum of the last row, which depends on all earlier ones; None without rows.
    """

    scenario: str
    rows: int
    last_row: str | None


@dataclass(frozen=True)
class Recorded:
    """Schema of run.json; other keys are ignored."""

    status: str
    message: str
    summary: dict[str, Any]
    events: tuple[Event, ...]
    plugins: dict[str, Any]
    header: dict[str, Any]
    log: LogOf
    timings: dict[str, float | None] = field(default_factory=dict)
    unused: tuple[str, ...] = ()
    loop: dict[str, Any] | None = None


def describe(run: Run) -> dict[str, Any]:
    """Return the content of run.json for a run, without its start and command line."""
    header = run.header.to_dict()
    del header["scenario_yaml"]  # stored as scenario.yaml
    return {
        "status": run.status,
        "message": run.message,
        "summary": run.summary(),
        "events": [asdict(event) for event in run.events],
        "timings": run.timings,
        "loop": loop(run),
        "unused": list(run.unused),
        "plugins": run.plugins,
        "header": header,
        "log": asdict(log_of(run.header, run.rows)),
    }


def log_of(header: Header, rows: Any) -> LogOf:
    """Return the identity of a log with these rows."""
    try:
        last = checksum(np.ascontiguousarray(rows[-1], dtype="<f8").tobytes()) if len(rows) else None
    except LogError:  # the log has changed in the meantime
        last = None
    return LogOf(checksum(header.scenario_yaml.encode(errors="backslashreplace")), len(rows), last)


def check_log(known: Mapping[str, Any], folder: Path, header: Header, rows: Any | None) -> None:
    """Raise LogError if run.json belongs to another log; `rows` is None for an incomplete log."""
    found = log_of(header, () if rows is None else rows)
    there = known["log"]
    same = there["scenario"] == found.scenario
    if rows is not None and known["status"] != "running":
        last = there["last_row"], found.last_row  # None: damaged, reported when rows are read
        same = same and there["rows"] == found.rows and (None in last or last[0] == last[1])
    if not same:
        raise LogError(f"{folder / NAME}: does not belong to the log in this folder; {WITHOUT}")


def loop(run: Run) -> dict[str, Any] | None:
    """Return whether the steps of a run were compiled as whole blocks, and the parts executed by Python."""
    return None if run.interpreted is None else {"blocks": not run.interpreted, "python": list(run.interpreted)}


def now() -> datetime:
    """Return the current time in UTC."""
    return datetime.now(UTC)


def encode(content: dict[str, Any]) -> bytes:
    """Return the bytes of run.json. Non-finite numbers become null."""
    text = json.dumps(sealed(to_json(content)), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    return text.encode(errors="backslashreplace")  # \udcff is a valid escape in JSON, too


def write(folder: Path, content: dict[str, Any]) -> None:
    """Replace run.json atomically."""
    replace(folder / NAME, encode(content))


def read(folder: Path) -> dict[str, Any] | None:
    """Return the content of run.json; None if it does not exist."""
    path = folder / NAME
    try:
        content = unsealed(path.read_bytes())
        check_type(content, Recorded)
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise LogError(f"{path}: cannot be read: {error}; {WITHOUT}") from error
    return content


def to_json(value: Any) -> Any:
    """Return `value` in the types of strict JSON; non-finite numbers become None."""
    if isinstance(value, dict):
        return {str(key): to_json(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_json(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
