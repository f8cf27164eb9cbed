"""Makes a complete log and a true run.json of what a killed run left."""

from __future__ import annotations

import contextlib
import os
import shutil
from dataclasses import dataclass
from pathlib import Path

from cdpr.errors import OutputError
from cdpr.log import run_json
from cdpr.log.files import unwritable
from cdpr.log.reader import Scan, locate, scan
from cdpr.log.run import Run
from cdpr.log.writer import LogWriter


@dataclass(frozen=True)
class RepairReport:
    """What `repair` found and did."""

    log: Path
    rows: int  # kept
    problem: str | None  # what was wrong with the log; None where it was complete
    torn: Path | None  # where the damaged log is kept
    interrupted: bool  # run.json said "running", now "interrupted"

    @property
    def changed(self) -> bool:
        """Whether anything was written."""
        return self.torn is not None or self.interrupted


def repair(path: str | Path) -> RepairReport:
    """Mend a run folder or a log; where nothing is wrong, do nothing.

    A torn or damaged log is written anew from its rows up to the first damage; the old one stays as
    `log.mcap.torn`. Status "running" in run.json becomes "interrupted". Not for a run that is still going on.

    Raises:
        LogError: there is no log, it is not ours, or nothing of it can be read.
        OutputError: the folder cannot be written.
    """
    log, folder = locate(path)
    found = scan(log)
    torn = None if found.problem is None else _rewrite(log, found)
    interrupted = folder is not None and _interrupt(folder, found)
    return RepairReport(log, len(found.rows), found.problem, torn, interrupted)


def _rewrite(log: Path, found: Scan) -> Path:
    temporary = log.with_name(f"{log.name}.tmp")
    try:
        LogWriter(temporary, found.header).close(found.rows, len(found.rows))
    except OutputError:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise
    torn = log.with_name(f"{log.name}.torn")
    number = 1
    while torn.exists():
        number += 1
        torn = log.with_name(f"{log.name}.torn-{number}")
    try:
        _keep(log, torn)
        os.replace(temporary, log)
    except OSError as error:
        raise unwritable(log, error) from error
    return torn


def _keep(log: Path, torn: Path) -> None:
    """Give the log a second name, so that there is no moment without one."""
    try:
        os.link(log, torn)
    except OSError:  # a file system without links
        shutil.copyfile(log, torn)


def _interrupt(folder: Path, found: Scan) -> bool:
    known = run_json.read(folder)
    if known is None or known.get("status") != "running":
        return False
    message = f"killed while it ran; {len(found.rows)} rows kept"
    run = Run(found.header, found.rows, "interrupted", message)
    told = ("argv", "started", "finished", "events", "timings", "unused")
    run_json.write(folder, run_json.describe(run) | {key: known[key] for key in told if key in known})
    return True
