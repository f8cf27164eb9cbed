"""Edits of files that carry a checksum, with a new checksum: what another version or another job would have written."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cdpr.base.checksums import sealed

Edit = Callable[[dict[str, Any]], object]


def edit_file(path: Path, edit: Edit, job: str = "") -> None:
    """Edit a JSON file."""
    content = json.loads(path.read_text())
    edit(content)
    path.write_text(json.dumps(sealed(content, job), indent=1) + "\n")


def edit_lines(ledger: Path, edit: Edit, *lines: int) -> None:
    """Edit lines of a ledger, counted from 0; the description beside it has the job's digest."""
    described = next(path for path in ledger.parent.glob("*.json") if path.stem in KINDS)
    job = json.loads(described.read_text())["digest"]
    rows = [json.loads(line) for line in ledger.read_text().splitlines()]
    for number in lines:
        edit(rows[number])
        rows[number] = sealed(rows[number], job)
    ledger.write_text("".join(json.dumps(row) + "\n" for row in rows))


KINDS = ("study", "rollout", "design", "workspace")
