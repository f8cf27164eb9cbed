"""Folder of a study, with the ledger of its cases and the kept runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from pydantic import TypeAdapter

from cdpr.analysis.jobs.folder import LEDGER_NAME, RESULTS, JobFolder, clear, read_rows
from cdpr.analysis.study.plan import Checked, Study
from cdpr.base.checksums import opened
from cdpr.base.errors import LogError

KIND = "study"
RUNS_NAME = "runs"


@dataclass(frozen=True)
class Described:
    """Parts of study.json that are read before the study itself."""

    digest: str
    checked: Mapping[str, Checked]


DESCRIBED = TypeAdapter(Described)


class StudyFolder(JobFolder):
    """Folder of one study, new or with some of its cases."""

    def __init__(self, path: Path, study: Study) -> None:
        checked = {case.id: asdict(case.checked) for case in study.cases}
        about = {"name": study.name, "cases": len(study.cases), "digest": study.digest, "checked": checked}
        super().__init__(path, KIND, about)

    def run_folder(self, case: str) -> Path:
        """Return the run folder of a case, after removing old content."""
        folder = self.path / RUNS_NAME / case
        clear(folder)  # left by a case that did not end
        return folder


def ended(path: Path) -> dict[str, tuple[Checked, Mapping[str, str]]]:
    """Return the cases of a study folder that have a result, for `load_study`; empty if there is no study.

    Errors of the folder are reported later by StudyFolder.
    """
    try:
        known = opened((path / f"{KIND}.json").read_bytes(), DESCRIBED)
        rows = read_rows((path / LEDGER_NAME).read_bytes(), path / LEDGER_NAME, known.digest)
    except (OSError, ValueError, LogError):
        return {}
    checked = known.checked
    return {key: (checked[key], row.versions) for key, row in rows.items() if key in checked and row.status in RESULTS}
