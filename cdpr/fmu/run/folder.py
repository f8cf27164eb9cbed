"""Temporary folders for extracted FMUs, removed soon after the end of their process.

A killed process cannot clean up. So each folder is locked while its process lives, and the next process that needs one
first removes those of this user without a lock.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from contextlib import suppress
from functools import cache
from weakref import finalize

from cdpr.base import ownership
from cdpr.base.errors import OutputError
from cdpr.base.locks import Lock, lock, open_to_lock

PREFIX = "cdpr-fmu-"
FLAGS = os.O_RDONLY | os.O_DIRECTORY


class Folder:
    """New folder of this process; `remove` removes it with its content, and may be called again.

    Raises:
        OutputError: if it cannot be created.
    """

    def __init__(self) -> None:
        try:
            _sweep_once(tempfile.gettempdir())
            self.path, file = _made()
        except OSError as error:
            raise OutputError(
                f"no temporary folder for an FMU can be made: {error.strerror or error}; set TMPDIR to a folder that "
                "can be written"
            ) from None
        self.remove = finalize(self, _remove, self.path, file)
        if found := ownership.fault(self.path):
            self.remove()
            raise OutputError(f"{self.path}: is not used for an FMU: {found}; or set TMPDIR to a folder of your own")


def sweep(root: str) -> None:
    """Remove the abandoned folders of this user in `root`; those in use or in doubt stay."""
    with suppress(OSError), os.scandir(root) as entries:
        for entry in entries:
            if entry.name.startswith(PREFIX):
                _remove_left(entry.path)


_sweep_once = cache(sweep)


def _made() -> tuple[str, int]:
    """Return a new folder and the descriptor of its lock."""
    while True:
        path = tempfile.mkdtemp(prefix=PREFIX)
        with suppress(FileNotFoundError):  # another process removed it before it was locked: try again
            file = open_to_lock(path, FLAGS)
            # Another process may be about to remove it; without support for locks, none does.
            if lock(file) is not Lock.ANOTHERS and _is(path, file):
                return path, file
            os.close(file)


def _remove_left(path: str) -> None:
    try:
        file = open_to_lock(path, FLAGS)
    except OSError:  # a link, no folder, of another user, or gone
        return
    try:
        if os.fstat(file).st_uid == os.geteuid() and lock(file) is Lock.OURS and _is(path, file):
            shutil.rmtree(path, ignore_errors=True)
    finally:
        os.close(file)


def _is(path: str, descriptor: int) -> bool:
    """Return whether the folder at `path` is the open one."""
    try:
        return os.path.samestat(os.lstat(path), os.fstat(descriptor))
    except FileNotFoundError:
        return False


def _remove(path: str, file: int) -> None:
    shutil.rmtree(path, ignore_errors=True)
    os.close(file)
