"""Problem reporting and file access for motions and events."""

from __future__ import annotations

import os

from cdpr.base.files import UnreadableError, read
from cdpr.base.problems import Mark, Path, shown
from cdpr.scenario.checks import Checks


class SectionReport:
    """Reporter and file reader of the section at `root`; files are relative to the scenario."""

    def __init__(self, checks: Checks, root: Path) -> None:
        self._checks, self._root = checks, root

    def add_problem(self, path: Path, text: str) -> None:
        """Report a problem of the value at `path`, relative to the section."""
        self._checks.add_problem((*self._root, *path), text)

    def add_file_problem(self, path: Path, file: str, line: int, column: int, text: str) -> None:
        """Report a problem in the file that is referenced at `path`."""
        self._checks.problems.add(Mark(self.path(file), line, column), (*self._root, *path), text)

    def path(self, file: str) -> str:
        """Return the path of a file, relative to the scenario."""
        return os.path.join(self._checks.document.folder, file)

    def read(self, path: Path, file: str, size: int, endings: tuple[str, ...]) -> bytes | None:
        """Return the content of the file referenced at `path`; report a problem and return None if it is unreadable."""
        if os.path.isabs(file):
            self.add_problem(path, f"expected a file name relative to this file, got the absolute {shown(file)}")
            return None
        try:
            return read(self.path(file), size, endings)
        except UnreadableError as error:
            self.add_problem(path, str(error))
            return None
