"""How a section that is a part of the scenario, a motion or an event, tells what is wrong and reads its files."""

from __future__ import annotations

import os

from cdpr.problems import Mark, Path, shown
from cdpr.scenario.checks import Checks
from cdpr.scenario.files import UnreadableError, read


class Below:
    """Reports what is wrong with the section at `root`, and reads its files, relative to the scenario."""

    def __init__(self, checks: Checks, root: Path) -> None:
        self._checks, self._root = checks, root

    def say(self, path: Path, text: str) -> None:
        """Report a problem of the value at `path`, below the section."""
        self._checks.say((*self._root, *path), text)

    def say_of_file(self, path: Path, file: str, line: int, column: int, text: str) -> None:
        """Report a problem of the file that is named at `path`."""
        self._checks.problems.add(Mark(self.path(file), line, column), (*self._root, *path), text)

    def path(self, file: str) -> str:
        """Return the path of a file that is named relative to the scenario."""
        return os.path.join(self._checks.document.folder, file)

    def read(self, path: Path, file: str, size: int, endings: tuple[str, ...]) -> bytes | None:
        """Return what the file that is named at `path` holds; None where it cannot be read, which is reported."""
        if os.path.isabs(file):
            self.say(path, f"a file name relative to this file is expected, got the absolute {shown(file)}")
            return None
        try:
            return read(self.path(file), size, endings)
        except UnreadableError as error:
            self.say(path, str(error))
            return None
