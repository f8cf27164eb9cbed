"""The folder of a study: what is run, and a ledger of how each case ended, whole at every moment."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from cdpr.errors import LogError, OutputError
from cdpr.locks import Lock, lock, open_to_lock
from cdpr.log.files import replace, unwritable
from cdpr.log.run import FORESEEN
from cdpr.log.run_json import plain
from cdpr.simulation.cases import Outcome
from cdpr.study.plan import Checked, Study

STUDY_NAME = "study.json"
LEDGER_NAME = "cases.jsonl"
RUNS_NAME = "runs"

RESULTS = (*FORESEEN, "diverged")  # what need not be run again

OURS = {STUDY_NAME, f"{STUDY_NAME}.tmp", LEDGER_NAME}  # may be there before a study is

LINE = TypeAdapter(Outcome)
CHECKED = TypeAdapter(Checked)


class StudyFolder:
    """A folder for one study, new or with some of its cases; locked while it is open.

    Attributes:
        rows: how the cases ended that did, by id.
    """

    def __init__(self, path: Path, study: Study) -> None:
        """Raises OutputError where the folder is taken, in use or cannot be written, LogError where it is spoilt."""
        self.path = path
        try:
            path.mkdir(parents=True, exist_ok=True)
            self._refuse_others()
            self._ledger = open_to_lock(path / LEDGER_NAME, os.O_RDWR | os.O_CREAT | os.O_APPEND)
        except FileExistsError as error:
            raise OutputError(f"{path}: is a file, not a folder; choose another --out") from error
        except OSError as error:
            raise unwritable(Path(error.filename or path), error) from error
        try:
            if lock(self._ledger) is Lock.ANOTHERS:
                raise OutputError(f"{path}: another cdpr study is at work there; wait for it, or end it")
            self._refuse_others()  # such as a run that began at the same moment
            if (path / STUDY_NAME).is_file():  # perhaps written by who had the lock
                self._expect(study, path / STUDY_NAME)
            else:
                content = {"name": study.name, "cases": len(study.cases), "digest": study.digest}
                checked = {case.id: asdict(case.checked) for case in study.cases}
                replace(path / STUDY_NAME, json.dumps(content | {"checked": checked}, indent=1) + "\n")
            self.rows = self._read()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Let others have it."""
        os.close(self._ledger)

    def run_folder(self, case: str) -> Path:
        """Where the run of a case is kept; nothing is there."""
        folder = self.path / RUNS_NAME / case
        clear(folder)  # of a case that did not end
        return folder

    def record(self, outcome: Outcome) -> None:
        """Keep how a case ended: one line, in one write, which a kill leaves out or whole."""
        line = json.dumps(plain(asdict(outcome)), ensure_ascii=False, allow_nan=False) + "\n"
        try:
            rest = memoryview(line.encode())
            while rest:
                rest = rest[os.write(self._ledger, rest) :]
        except OSError as error:
            raise unwritable(self.path / LEDGER_NAME, error) from error
        self.rows[outcome.key] = outcome

    def _refuse_others(self) -> None:
        strange = {entry.name for entry in self.path.iterdir()} - OURS
        if strange and not (self.path / STUDY_NAME).is_file():
            raise OutputError(f"{self.path}: exists, is not empty and holds no study; choose another --out")

    def _expect(self, study: Study, description: Path) -> None:
        """Refuse a folder that holds another study."""
        try:
            known: Mapping[str, Any] = json.loads(description.read_text(encoding="utf-8"))
            digest = known["digest"]
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise LogError(f"{description}: cannot be read ({error}); choose another --out") from error
        if digest != study.digest:
            raise OutputError(
                f"{self.path}: holds another study, '{known.get('name')}' of {known.get('cases')} cases; this is "
                f"'{study.name}' of {len(study.cases)}, or its scenario has changed since; choose another --out"
            )

    def _read(self) -> dict[str, Outcome]:
        """Return the last line of each case; a line that was torn by a kill is cut off."""
        with open(os.dup(self._ledger), "rb") as file:
            file.seek(0)
            found = file.read()
        whole = found[: found.rfind(b"\n") + 1]
        if len(whole) < len(found):
            os.ftruncate(self._ledger, len(whole))
        return _rows(whole, self.path / LEDGER_NAME)


def ended(path: Path) -> dict[str, tuple[Checked, Mapping[str, str]]]:
    """Return, for `load_study`, the cases of the folder `path` that have their result; none where it is no study's.

    What is wrong with the folder is told by StudyFolder.
    """
    try:
        checked = json.loads((path / STUDY_NAME).read_text(encoding="utf-8"))["checked"]
        found = (path / LEDGER_NAME).read_bytes()
        rows = _rows(found[: found.rfind(b"\n") + 1], path / LEDGER_NAME)
        known = {key: CHECKED.validate_python(checked[key]) for key in rows if key in checked}
    except (OSError, ValueError, KeyError, TypeError, RecursionError, LogError):
        return {}
    return {key: (known[key], row.versions) for key, row in rows.items() if key in known and row.status in RESULTS}


def _rows(lines: bytes, path: Path) -> dict[str, Outcome]:
    """Return the last line of each case. Raises LogError."""
    rows: dict[str, Outcome] = {}
    for number, line in enumerate(lines.splitlines(), 1):
        try:
            row = LINE.validate_json(line)
        except ValidationError as error:
            first = error.errors()[0]
            what = ": ".join([*map(str, first["loc"]), first["msg"]])
            text = f"cannot be read ({what}); remove that line, and its case is run again"
            raise LogError(f"{path}:{number}: {text}") from error
        rows[row.key] = row
    return rows


def clear(folder: Path) -> None:
    """Remove a run folder, where there is one."""
    with contextlib.suppress(FileNotFoundError):
        shutil.rmtree(folder)
