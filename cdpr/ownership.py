"""Checks of who else may write to a file that cdpr executes, or that decides what is executed.

Such a file is used only if it and all folders on the way to it belong to this user or to root, and nobody else may
write to them. In a folder like /tmp, where the sticky bit is set, others cannot replace what they do not own.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

OTHERS = stat.S_IWGRP | stat.S_IWOTH


def fault(path: str | os.PathLike[str]) -> str:
    """Return what is wrong with a file or a folder, or with a folder on the way to it; "" if nothing.

    Raises OSError where it cannot be looked up.
    """
    whole = Path(os.path.abspath(path))
    real = Path(os.path.realpath(whole))
    for place in (real, *real.parents, *(folder for folder in whole.parents if folder not in real.parents)):
        if found := fault_of(os.stat(place), str(place), on_the_way=place != real):
            return found
    return ""


def fault_of(about: os.stat_result, name: str, *, on_the_way: bool = False) -> str:
    """Return what is wrong with an open file, or with a folder on the way to a file; "" if nothing."""
    if about.st_uid not in (0, os.geteuid()):
        return f"{name} belongs to another user"
    if about.st_mode & OTHERS and not (on_the_way and about.st_mode & stat.S_ISVTX):
        return f"others may write to {name} (chmod go-w)"
    return ""


def make_private(folder: Path, own: Path) -> None:
    """Make a folder; missing ones on the way are made for this user alone.

    Others lose the right to write to what is there from `own` on, where it belongs to this user. Raises OSError where
    one cannot be made.
    """
    for place in reversed((folder, *folder.parents)):
        if not place.exists():
            place.mkdir(mode=0o700, exist_ok=True)
        elif place.is_relative_to(own):
            about = place.stat()
            if about.st_uid == os.geteuid() and about.st_mode & OTHERS and not about.st_mode & stat.S_ISVTX:
                place.chmod(stat.S_IMODE(about.st_mode) & ~OTHERS)
    folder.mkdir(exist_ok=True)  # raises what is wrong where something else has its name


def read_private(path: Path) -> bytes:
    """Return the content of a regular file that nobody else may write to; its folders were checked before.

    Raises FileNotFoundError where there is none, PermissionError, with the reason, where it may not be used.
    """
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK | os.O_NOFOLLOW)) as file:
        about = os.fstat(file.fileno())
        if not stat.S_ISREG(about.st_mode):
            raise PermissionError(f"{path} is not a regular file")
        if found := fault_of(about, str(path)):
            raise PermissionError(found)
        return file.read()
