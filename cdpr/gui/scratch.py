"""Folders for runs too long for the memory: each is gone with its window, or with the next where that was killed."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path

from cdpr.locks import Lock, lock, open_to_lock

PREFIX = "cdpr-gui-"


class _Held:
    """A folder that is open to be locked; the lock goes with the process, however it ends."""

    def __init__(self, path: Path) -> None:
        self._file = open_to_lock(path, os.O_RDONLY | os.O_DIRECTORY)
        self.lock = lock(self._file)
        with suppress(OSError):
            self.there = os.path.samestat(os.fstat(self._file), os.lstat(path))
            return
        self.there = False

    def close(self) -> None:
        os.close(self._file)


@contextmanager
def scratch() -> Iterator[Path]:
    """Make a folder, locked while it is needed, and remove it."""
    while True:
        path = Path(tempfile.mkdtemp(prefix=PREFIX))
        try:
            held = _Held(path)
        except FileNotFoundError:
            continue  # `sweep` of another window was faster than the lock
        with closing(held):
            if not held.there or held.lock is Lock.ANOTHERS:
                continue  # likewise
            try:
                yield path
            finally:
                shutil.rmtree(path, ignore_errors=True)
            return


def sweep() -> None:
    """Remove the folders of windows that were killed; where locks cannot tell, none."""
    for path in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError), closing(_Held(path)) as held:
            if held.lock is Lock.OURS and os.lstat(path).st_uid == os.getuid():
                shutil.rmtree(path, ignore_errors=True)
