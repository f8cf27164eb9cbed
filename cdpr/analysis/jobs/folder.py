"""Folder of a job with many cases: its description, and a ledger of outcomes that is valid at any moment."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from cdpr.analysis.jobs.cases import Outcome
from cdpr.base.checksums import opened, sealed
from cdpr.base.errors import LogError, OutputError
from cdpr.base.incomplete import is_temporary_of
from cdpr.base.locks import Lock, lock, open_to_lock
from cdpr.log.files import replace, unwritable
from cdpr.log.run import FORESEEN
from cdpr.log.run_json import to_json

LEDGER_NAME = "cases.jsonl"

RESULTS = (*FORESEEN, "diverged")  # statuses that are not run again

LINE = TypeAdapter(Outcome)


@dataclass(frozen=True)
class Described:
    """Common part of the descriptions of all kinds of folders; other keys are ignored."""

    name: str
    cases: int
    digest: str


DESCRIBED = TypeAdapter(Described)


class JobFolder:
    """Folder of one job, such as a study, new or with some of its cases; locked while it is open.

    Attributes:
        rows: outcomes of the finished cases by id.
    """

    def __init__(self, path: Path, kind: str, content: Mapping[str, Any]) -> None:
        """Open a folder.

        Args:
            path: the folder.
            kind: kind of job, such as "study".
            content: description with name, cases and digest.

        Raises:
            OutputError: if the folder has other content, is in use or cannot be written.
            LogError: if it is damaged.
        """
        self.path, self._kind = path, kind
        self._description = description = path / f"{kind}.json"
        self._digest = str(content["digest"])
        try:
            path.mkdir(parents=True, exist_ok=True)
            self._refuse_others()
            self._ledger = open_to_lock(path / LEDGER_NAME, os.O_RDWR | os.O_CREAT | os.O_APPEND)
        except FileExistsError as error:
            raise OutputError(f"{path}: is a file, not a folder; choose another name") from error
        except OSError as error:
            raise unwritable(Path(error.filename or path), error) from error
        try:
            if lock(self._ledger) is Lock.ANOTHERS:
                raise OutputError(f"{path}: another cdpr {kind} is at work there; wait for it, or end it")
            self._refuse_others()  # another process may have started at the same moment
            if description.is_file():  # possibly written by the previous owner of the lock
                self._expect(content)
            else:
                replace(description, json.dumps(sealed(content), indent=1) + "\n")
            self.rows = self._read()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Release the lock."""
        os.close(self._ledger)

    def record(self, outcome: Outcome) -> None:
        """Append an outcome to the ledger: one line in one write, which is complete or absent after a kill."""
        content = sealed(to_json(asdict(outcome)), self._digest)
        line = json.dumps(content, ensure_ascii=False, allow_nan=False) + "\n"
        try:
            rest = memoryview(line.encode())
            while rest:
                rest = rest[os.write(self._ledger, rest) :]
        except OSError as error:
            raise unwritable(self.path / LEDGER_NAME, error) from error
        self.rows[outcome.key] = outcome

    def _refuse_others(self) -> None:
        ours = {self._description.name, LEDGER_NAME}  # these and temporary files may exist before the first case
        strange = {entry.name for entry in self.path.iterdir() if not is_temporary_of(entry.name, self._description)}
        strange -= ours
        if strange and not self._description.is_file():
            text = f"exists, is not empty and contains no {self._kind}; choose another folder"
            raise OutputError(f"{self.path}: {text}")

    def _expect(self, content: Mapping[str, Any]) -> None:
        """Raise an error if the folder belongs to another job."""
        try:
            known = opened(self._description.read_bytes(), DESCRIBED)
        except ValueError as error:
            raise LogError(f"{self._description}: cannot be read ({error}); choose another folder") from error
        if known.digest != content["digest"]:
            raise OutputError(
                f"{self.path}: contains another {self._kind}, '{known.name}' of {known.cases} cases; this "
                f"is '{content['name']}' of {content['cases']}, or its files have changed since; choose another "
                "folder"
            )

    def _read(self) -> dict[str, Outcome]:
        """Return the last line of each case; an incomplete last line is removed."""
        with open(os.dup(self._ledger), "rb") as file:
            file.seek(0)
            found = file.read()
        whole = found[: found.rfind(b"\n") + 1]
        if len(whole) < len(found):
            os.ftruncate(self._ledger, len(whole))
        return read_rows(whole, self.path / LEDGER_NAME, self._digest)


def read_rows(lines: bytes, path: Path, digest: str) -> dict[str, Outcome]:
    """Return the last line of each case; `digest` is that of the folder's description.

    Raises:
        LogError: if a line is damaged.
    """
    rows: dict[str, Outcome] = {}
    for number, line in enumerate(lines.split(b"\n")[:-1], 1):
        try:
            row = opened(line, LINE, digest)
        except ValueError as error:
            text = f"cannot be read ({error}); remove that line, and its case is run again"
            raise LogError(f"{path}:{number}: {text}") from error
        rows[row.key] = row
    return rows


def clear(folder: Path) -> None:
    """Remove a run folder if it exists."""
    with contextlib.suppress(FileNotFoundError):
        shutil.rmtree(folder)
