"""What tests of workspaces in chunks share."""

from __future__ import annotations

from pathlib import Path

from cdpr.analysis.jobs.folder import LEDGER_NAME


def content(folder: Path) -> dict[str, object]:
    """All that a folder of chunks holds, to the byte, but for the order in which they came."""
    files = {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    return {**files, LEDGER_NAME: sorted(set(files[LEDGER_NAME].splitlines()))}
