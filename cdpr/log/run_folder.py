"""The folder of a run: scenario.yaml as resolved, run.json and, written by the recorder, log.mcap."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.errors import OutputError
from cdpr.log import run_json
from cdpr.log.files import replace, unwritable
from cdpr.log.run import Header, Run

RUNS = Path("runs")
SCENARIO_NAME = "scenario.yaml"


class RunFolder:
    """A new folder for one run, with its run.json.

    Args:
        out: the folder, which must be empty or not exist; None for `runs/<UTC>_<scenario>_<backend>`, with
            -2, -3, ... where that exists.
        header: what will be run.
        argv: the command line, for the record.

    Raises OutputError where the folder is taken or cannot be written.
    """

    def __init__(self, out: Path | None, header: Header, argv: Sequence[str] = ()) -> None:
        started = run_json.now()
        self.path = new_folder(header.scenario, header.backend) if out is None else empty_folder(out)
        self._started: dict[str, Any] = {
            "argv": list(argv),
            "started": started.isoformat(timespec="seconds"),
            "finished": None,
        }
        replace(self.path / SCENARIO_NAME, header.scenario_yaml)
        no_rows = Run(header, np.empty((0, header.layout.width)), status="running")
        run_json.write(self.path, run_json.describe(no_rows) | self._started)

    def finish(self, run: Run) -> None:
        """Say in run.json how the run ended."""
        finished = {"finished": run_json.now().isoformat(timespec="seconds")}
        run_json.write(self.path, run_json.describe(run) | self._started | finished)


def new_folder(*names: str) -> Path:
    """Make `runs/<UTC>_<names>`, with -2, -3, ... where that exists. Raises OutputError."""
    path = RUNS / "_".join([f"{run_json.now():%Y%m%d-%H%M%S}", *map(safe_name, names)])
    try:
        for number in itertools.count(1):
            folder = path if number == 1 else path.with_name(f"{path.name}-{number}")
            try:
                folder.mkdir(parents=True)
            except FileExistsError:
                continue
            return folder
    except OSError as error:
        raise unwritable(path, error) from error
    raise AssertionError("unreachable")


def empty_folder(folder: Path) -> Path:
    """Make a folder that is empty, or take one; OutputError where it is not or cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        taken = any(folder.iterdir())
    except FileExistsError as error:
        raise OutputError(f"{folder}: is a file, not a folder; choose another --out") from error
    except OSError as error:
        raise unwritable(folder, error) from error
    if taken:
        raise OutputError(f"{folder}: exists and is not empty; choose another --out or remove it")
    return folder


def safe_name(name: str) -> str:
    """`name` as part of a file name."""
    return re.sub(r"[^\w.-]+", "-", name).strip(".-")[:80] or "run"
