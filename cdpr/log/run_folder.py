"""Folder of a run: resolved scenario.yaml, run.json and, written by the recorder, log.mcap."""

from __future__ import annotations

import contextlib
import itertools
import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.base.errors import OutputError
from cdpr.log import run_json
from cdpr.log.files import Reserved, beside, output_path, replace, require_process, unwritable
from cdpr.log.header import Header
from cdpr.log.run import Run

RUNS = Path("runs")
SCENARIO_NAME = "scenario.yaml"
IMAGES_NAME = "images.mcap"  # of the cameras

ROOM = 65536  # bytes reserved for the final run.json in addition to twice its initial size: events, timings


class RunFolder:
    """New folder for one run with its run.json, for which the final space is reserved from the start.

    Args:
        out: folder, which must be empty or not exist; None for `runs/<UTC>_<scenario>_<backend>`, with -2, -3, ... if
            that exists.
        header: description of the run.
        argv: command line, for the record.
        branch: folder and time of the parent run, for the record of a branch.
        first: folder of the first run of a series of branches; this folder by default.
        scenario: function that returns the text of scenario.yaml for a folder, to which its file names are relative;
            the header's text by default.

    Raises:
        OutputError: if the folder is in use or cannot be written.
    """

    def __init__(
        self,
        out: Path | None,
        header: Header,
        argv: Sequence[str] = (),
        *,
        branch: Mapping[str, Any] | None = None,
        first: Path | None = None,
        scenario: Callable[[str], str] | None = None,
    ) -> None:
        self._process = os.getpid()
        started = run_json.now()
        self._started: dict[str, Any] = {
            "argv": list(argv),
            "started": started.isoformat(timespec="seconds"),
            "finished": None,
            **({} if branch is None else {"branch": dict(branch)}),
        }
        text = self._unfinished_text(header)
        self._created = out is None
        self.path = new_folder(header.scenario, header.backend) if out is None else out
        file = self.path / run_json.NAME
        self.header, self.first = header, first or self.path
        claim(self.path, beside(file).name)
        try:
            self._end = Reserved(file, 2 * len(text) + ROOM)
            text_here = header.scenario_yaml if scenario is None else scenario(os.path.abspath(self.path))
            replace(self.path / SCENARIO_NAME, text_here)
            replace(file, text)
        except BaseException:
            self.withdraw()
            raise

    def _unfinished_text(self, header: Header) -> bytes:
        """Return run.json of a running run."""
        no_rows = Run(header, np.empty((0, header.layout.width)), status="running")
        return run_json.encode(run_json.describe(no_rows) | self._started)

    def revise(self, header: Header) -> None:
        """Write a header with a live change, which the log does not contain, in case the run is killed.

        Raises:
            OutputError: if it cannot be written; run.json is then unchanged.
        """
        if header != self.header:
            replace(self.path / run_json.NAME, self._unfinished_text(header))
            self.header = header

    def finish(self, run: Run) -> None:
        """Write the end of the run to run.json.

        Raises:
            OutputError: if it does not fit; a shorter version is then written.
        """
        require_process(self._process, self.path)
        finished = {"finished": run_json.now().isoformat(timespec="seconds")}
        content = run_json.describe(run) | self._started | finished
        try:
            self._end.write(run_json.encode(content))
        except OutputError as error:
            brief = {"status": "failed", "message": run.message or str(error), "events": [], "plugins": {}}
            with contextlib.suppress(OutputError):
                self._end.write(run_json.encode(content | brief))
            self._end.release()
            raise

    def withdraw(self, *others: str) -> None:
        """Remove all files of a run without a sample, and `others`; a folder given by the user remains, empty."""
        if os.getpid() != self._process:
            return
        for name in (run_json.NAME, SCENARIO_NAME, beside(self.path / run_json.NAME).name, *others):
            with contextlib.suppress(OSError):
                (self.path / name).unlink()
        if self._created:
            with contextlib.suppress(OSError):
                self.path.rmdir()


def folder_name(out: object) -> Path:
    """Return the path of a run folder.

    Raises:
        OutputError: if `out` is no file name.
    """
    return output_path(out, "out", "folder")


def next_folder(path: Path) -> Path:
    """Return the first of PATH-2, PATH-3, ... that does not exist."""
    return next(
        folder for number in itertools.count(2) if not (folder := path.with_name(f"{path.name}-{number}")).exists()
    )


def new_folder(*names: str) -> Path:
    """Create `runs/<UTC>_<names>`, with -2, -3, ... if that exists.

    Raises:
        OutputError: if it cannot be created.
    """
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


def claim(folder: Path, first: str) -> None:
    """Create a folder or claim an empty one with the empty file `first`; at most one of several processes succeeds.

    Raises:
        OutputError: if it is not empty, claimed by another process, or cannot be created.
    """
    taken = OutputError(f"{folder}: exists and is not empty; choose another folder or remove it")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        raise OutputError(f"{folder}: is a file, not a folder; choose another name") from error
    except OSError as error:
        raise unwritable(folder, error) from error
    try:
        if os.listdir(folder):
            raise taken
        os.close(os.open(folder / first, os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666))
        if os.listdir(folder) != [first]:  # another process created a file at the same moment
            (folder / first).unlink()
            raise taken
    except FileExistsError:
        raise taken from None
    except OSError as error:
        raise unwritable(folder, error) from error


def safe_name(name: str) -> str:
    """Return `name` as part of a file name."""
    return re.sub(r"[^\w.-]+", "-", name).strip(".-")[:80] or "run"
