"""The folder of a study: that of its cases, and the runs that are kept."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from pydantic import TypeAdapter

from cdpr.errors import LogError
from cdpr.jobs.folder import LEDGER_NAME, RESULTS, JobFolder, clear, read_rows
from cdpr.study.plan import Checked, Study

KIND = "study"
RUNS_NAME = "runs"

CHECKED = TypeAdapter(Checked)


class StudyFolder(JobFolder):
    """A folder for one study, new or with some of its cases."""

    def __init__(self, path: Path, study: Study) -> None:
        checked = {case.id: asdict(case.checked) for case in study.cases}
        about = {"name": study.name, "cases": len(study.cases), "digest": study.digest, "checked": checked}
        super().__init__(path, KIND, about)

    def run_folder(self, case: str) -> Path:
        """Where the run of a case is kept; nothing is there."""
        folder = self.path / RUNS_NAME / case
        clear(folder)  # of a case that did not end
        return folder


def ended(path: Path) -> dict[str, tuple[Checked, Mapping[str, str]]]:
    """Return, for `load_study`, the cases of the folder `path` that have their result; none where it is no study's.

    What is wrong with the folder is told by StudyFolder.
    """
    try:
        checked = json.loads((path / f"{KIND}.json").read_text(encoding="utf-8"))["checked"]
        found = (path / LEDGER_NAME).read_bytes()
        rows = read_rows(found[: found.rfind(b"\n") + 1], path / LEDGER_NAME)
        known = {key: CHECKED.validate_python(checked[key]) for key in rows if key in checked}
    except (OSError, ValueError, KeyError, TypeError, RecursionError, LogError):
        return {}
    return {key: (known[key], row.versions) for key, row in rows.items() if key in known and row.status in RESULTS}
