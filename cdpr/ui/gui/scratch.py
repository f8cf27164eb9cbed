"""Temporary folders for runs that exceed the memory.

Each is removed with its window or, if that was killed, by the next window.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path

from cdpr.base.locks import Lock, lock, open_to_lock

PREFIX = "cdpr-gui-"


class _Held:
    """Opened and locked folder; the lock ends with the process."""

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
    """Create a folder, keep it locked while it is used, and remove it."""
    while True:
        path = Path(tempfile.mkdtemp(prefix=PREFIX))
        try:
            held = _Held(path)
        except FileNotFoundError:
            continue  # `sweep` of another window removed it before it was locked
        with closing(held):
            if not held.there or held.lock is Lock.ANOTHERS:
                continue  # as above
            try:
                yield path
            finally:
                shutil.rmtree(path, ignore_errors=True)
            return


def sweep() -> None:
    """Remove the folders of killed windows; if locks are not supported, none."""
    for path in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError), closing(_Held(path)) as held:
            if held.lock is Lock.OURS and os.lstat(path).st_uid == os.getuid():
                shutil.rmtree(path, ignore_errors=True)
