"""Temporary folders that are removed soon after the end of their process, even if it is killed.

A killed process cannot clean up. So each folder is locked while its process lives, and the next process that needs one
first removes those of this user without a lock.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from typing import Self
from weakref import finalize

from cdpr.base.locks import Lock, lock, open_to_lock

FLAGS = os.O_RDONLY | os.O_DIRECTORY


class TemporaryFolder:
    """New folder of this process; also a context manager.

    Args:
        prefix: first part of its name, by which abandoned ones are found.
        root: folder that contains it; by default that for temporary files.

    Attributes:
        path: of the folder.
        remove: removes it with its content; may be called again.

    Raises:
        OSError: if it cannot be created.
    """

    def __init__(self, prefix: str, root: str | None = None) -> None:
        root = root or tempfile.gettempdir()
        _sweep_once(root, prefix)
        self.path, file = _new_folder(prefix, root)
        self.remove = finalize(self, _remove, self.path, file, os.getpid())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.remove()


def sweep(root: str, prefix: str) -> None:
    """Remove the abandoned folders of this user in `root`; those in use or in doubt stay."""
    with suppress(OSError), os.scandir(root) as entries:
        for entry in entries:
            if entry.name.startswith(prefix):
                remove_abandoned(entry.path, FLAGS, partial(shutil.rmtree, ignore_errors=True))


_sweep_once = cache(sweep)


def _new_folder(prefix: str, root: str) -> tuple[str, int]:
    """Return a new folder and the descriptor of its lock."""
    while True:
        path = tempfile.mkdtemp(prefix=prefix, dir=root)
        with suppress(FileNotFoundError):  # another process removed it before it was locked: try again
            file = open_to_lock(path, FLAGS)
            # Another process may be about to remove it; without support for locks, none does.
            if lock(file) is not Lock.ANOTHERS and is_open(path, file):
                return path, file
            os.close(file)


def remove_abandoned(path: str, flags: int, remove: Callable[[str], object]) -> None:
    """Remove a folder or file of this user that no process has locked; `flags` are those to open it."""
    try:
        file = open_to_lock(path, flags)
    except OSError:  # a link, of another kind or user, or gone
        return
    try:
        if os.fstat(file).st_uid == os.geteuid() and lock(file) is Lock.OURS and is_open(path, file):
            with suppress(OSError):
                remove(path)
    finally:
        os.close(file)


def is_open(path: str | Path, descriptor: int) -> bool:
    """Return True if the folder or file at `path` is the open one."""
    try:
        return os.path.samestat(os.lstat(path), os.fstat(descriptor))
    except FileNotFoundError:
        return False


def _remove(path: str, file: int, process: int) -> None:
    if os.getpid() == process:  # not a fork of it
        shutil.rmtree(path, ignore_errors=True)
        os.close(file)
