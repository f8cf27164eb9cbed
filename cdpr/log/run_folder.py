"""The folder of a run: scenario.yaml as resolved, run.json and, written by the recorder, log.mcap."""

from __future__ import annotations

import contextlib
import itertools
import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.errors import OutputError
from cdpr.log import run_json
from cdpr.log.files import Reserved, beside, is_name, replace, require_process, unwritable
from cdpr.log.run import Header, Run

RUNS = Path("runs")
SCENARIO_NAME = "scenario.yaml"

ROOM = 65536  # bytes that run.json may need in the end beyond twice what it needs at the start: events, timings


class RunFolder:
    """A new folder for one run, with its run.json, for whose end there is room from the start.

    Args:
        out: the folder, which must be empty or not exist; None for `runs/<UTC>_<scenario>_<backend>`, with
            -2, -3, ... where that exists.
        header: what will be run.
        argv: the command line, for the record.
        first: where a series of branches began, itself unless given.
        scenario: makes the text of scenario.yaml for the folder where it stands, as its names of files are relative to
            that; the header's unless given.
        branch: of a run that goes on from another: the folder and the time of that, for the record.

    Raises OutputError where the folder is taken or cannot be written.
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
        text = self._begun(header)
        self._made = out is None
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

    def _begun(self, header: Header) -> bytes:
        """Return run.json of a run that has not ended."""
        no_rows = Run(header, np.empty((0, header.layout.width)), status="running")
        return run_json.encode(run_json.describe(no_rows) | self._started)

    def revise(self, header: Header) -> None:
        """Write a header that a live change has changed, which is not in the log, for the case of a kill.

        Raises OutputError; run.json is as before then.
        """
        if header != self.header:
            replace(self.path / run_json.NAME, self._begun(header))
            self.header = header

    def finish(self, run: Run) -> None:
        """Write to run.json how the run ended. Raises OutputError, after writing as much as there is room for."""
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
        """Leave nothing of a run without a sample, nor its other files; a folder that was given stays, empty."""
        if os.getpid() != self._process:
            return
        for name in (run_json.NAME, SCENARIO_NAME, beside(self.path / run_json.NAME).name, *others):
            with contextlib.suppress(OSError):
                (self.path / name).unlink()
        if self._made:
            with contextlib.suppress(OSError):
                self.path.rmdir()


def folder_name(out: object) -> Path:
    """Return the path of a run folder; OutputError where it is none."""
    if not isinstance(out, str | os.PathLike) or not is_name(out):
        raise OutputError(f"out: the name of a folder is expected, got {out!r}")
    return Path(out)


def next_folder(path: Path) -> Path:
    """Return PATH-2, PATH-3, ..., the first that does not exist."""
    return next(
        folder for number in itertools.count(2) if not (folder := path.with_name(f"{path.name}-{number}")).exists()
    )


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


def claim(folder: Path, first: str) -> None:
    """Make a folder, or take an empty one, by the empty file `first`: of several processes at most one gets it.

    Raises OutputError where it is not empty, is another's or cannot be made.
    """
    taken = OutputError(f"{folder}: exists and is not empty; choose another --out or remove it")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        raise OutputError(f"{folder}: is a file, not a folder; choose another --out") from error
    except OSError as error:
        raise unwritable(folder, error) from error
    try:
        if os.listdir(folder):
            raise taken
        os.close(os.open(folder / first, os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666))
        if os.listdir(folder) != [first]:  # another came at the same moment, with another file
            (folder / first).unlink()
            raise taken
    except FileExistsError:
        raise taken from None
    except OSError as error:
        raise unwritable(folder, error) from error


def safe_name(name: str) -> str:
    """`name` as part of a file name."""
    return re.sub(r"[^\w.-]+", "-", name).strip(".-")[:80] or "run"
