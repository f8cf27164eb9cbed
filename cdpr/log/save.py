"""A run that was kept in memory, written after all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from cdpr.log.mcap_file import LOG_NAME
from cdpr.log.run import Run
from cdpr.log.run_folder import RunFolder
from cdpr.log.writer import LogWriter


def save(run: Run, out: Path | None, argv: Sequence[str] = (), scenario: Callable[[str], str] | None = None) -> Run:
    """Write a run as the folder that it would have, had it logged from the start; return it with that folder.

    Args:
        run: finished, or as far as it has come.
        out: a new or empty folder; None for one in `runs/`.
        argv: the command line, for the record.
        scenario: makes the text of scenario.yaml, as for a `RunFolder`.

    Raises OutputError where the folder is taken or cannot be written.
    """
    folder = RunFolder(out, run.header, argv, scenario=scenario)
    saved = replace(run, folder=str(folder.path))
    try:
        LogWriter(folder.path / LOG_NAME, run.header).close(run.rows, len(run.rows))
    finally:
        folder.finish(saved)
    return saved
