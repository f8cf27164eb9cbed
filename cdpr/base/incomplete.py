"""Incomplete files beside their final names, which are removed even if their writer was killed.

As in `cdpr.base.temporary`, each is locked while it is written. The next process that writes into the folder first
removes those of this user without a lock.
"""

from __future__ import annotations

import os
import re
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from cdpr.base.locks import Lock, lock, open_to_lock
from cdpr.base.temporary import is_open, remove_abandoned

TEMPORARY = ".tmp"  # end of the names of incomplete files
NAME_LENGTH = 40  # characters of the final name in them: file systems limit names to 255 bytes
NAME = re.compile(r".{0,40}\.[0-9a-f]{12}\.tmp", re.DOTALL)
FLAGS = os.O_RDWR | os.O_CREAT | os.O_EXCL


def is_temporary_of(name: str, path: Path) -> bool:
    """Return True if `name` is that of incomplete content of a file, such as of a killed process."""
    return name.startswith(f"{path.name[:NAME_LENGTH]}.") and name.endswith(TEMPORARY)


@contextmanager
def incomplete(path: Path) -> Iterator[Path]:
    """Create an empty file in the folder of `path`, for its content until that is complete; yield its path.

    At the end it is removed, unless it was renamed. Until then it is locked.

    Raises:
        OSError: if it cannot be created.
    """
    _sweep_once(os.path.abspath(path.parent))
    temporary, file = _new_file(path)
    try:
        yield temporary
    finally:
        with suppress(OSError):
            temporary.unlink()
        os.close(file)


def sweep(folder: str) -> None:
    """Remove the abandoned incomplete files of this user in a folder; those in use or in doubt stay."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if NAME.fullmatch(entry.name):
                remove_abandoned(entry.path, os.O_RDONLY, os.unlink)


_sweep_once = cache(sweep)


def _new_file(path: Path) -> tuple[Path, int]:
    """Return a new file in the folder of `path`, and the descriptor of its lock."""
    while True:
        temporary = path.with_name(f"{path.name[:NAME_LENGTH]}.{secrets.token_hex(6)}{TEMPORARY}")
        file = open_to_lock(temporary, FLAGS)
        # Another process may remove it before it is locked: try again. Without support for locks, none does.
        if lock(file) is not Lock.ANOTHERS and is_open(temporary, file):
            return temporary, file
        os.close(file)
