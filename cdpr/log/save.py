"""Saving of a run that was kept in memory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from cdpr.log.mcap_file import LOG_NAME
from cdpr.log.run import Run
from cdpr.log.run_folder import RunFolder
from cdpr.log.writer import LogWriter


def save(run: Run, out: Path | None, argv: Sequence[str] = (), scenario: Callable[[str], str] | None = None) -> Run:
    """Write a run as the folder of a run logged from the start; return the run with that folder.

    Args:
        run: finished or partial run.
        out: new or empty folder; None for one in `runs/`.
        argv: command line, for the record.
        scenario: function that returns the text of scenario.yaml, as in `RunFolder`.

    Raises:
        OutputError: if the folder is in use or cannot be written.
    """
    folder = RunFolder(out, run.header, argv, scenario=scenario)
    saved = replace(run, folder=str(folder.path))
    try:
        LogWriter(folder.path / LOG_NAME, run.header).close(run.rows, len(run.rows))
    finally:
        folder.finish(saved)
    return saved
