"""run.json: how a run went. It is always whole, and says "running" until the run has ended."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from cdpr.errors import LogError
from cdpr.log.files import replace
from cdpr.log.run import Run

NAME = "run.json"


def describe(run: Run) -> dict[str, Any]:
    """Return what run.json says of a run, apart from when and how it was started."""
    header = run.header.to_dict()
    del header["scenario_yaml"]  # stands beside it as scenario.yaml
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
    }


def loop(run: Run) -> dict[str, Any] | None:
    """Return whether the steps of a run were compiled as whole blocks, and what of them Python did."""
    return None if run.interpreted is None else {"blocks": not run.interpreted, "python": list(run.interpreted)}


def now() -> datetime:
    """Return the time of day in UTC."""
    return datetime.now(UTC)


def encode(content: dict[str, Any]) -> bytes:
    """Return the bytes of run.json. Numbers that are not finite become null."""
    text = json.dumps(plain(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    return text.encode(errors="backslashreplace")  # \udcff is such an escape in JSON, too


def write(folder: Path, content: dict[str, Any]) -> None:
    """Replace run.json in one step."""
    replace(folder / NAME, encode(content))


def read(folder: Path) -> dict[str, Any] | None:
    """Return the content of run.json, None where there is none."""
    path = folder / NAME
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(content, dict):
            raise ValueError("not an object")
    except FileNotFoundError:
        return None
    except (OSError, ValueError, RecursionError) as error:
        raise LogError(f"{path}: cannot be read: {error}; without that file the log still loads") from error
    return content


def plain(value: Any) -> Any:
    """Return `value` in the types of strict JSON; numbers that are not finite become None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
