"""Folder of cdpr in the user's cache, for exported FMUs and their libraries."""

from __future__ import annotations

import atexit
import contextlib
import os
import shutil
import stat
import tempfile
from functools import lru_cache
from pathlib import Path

from cdpr.base.errors import OutputError

PASSING = "cdpr-passing-"  # first part of the name of a folder that is removed when its process ends


def user_cache() -> Path:
    """Return the folder of cdpr in the user's cache; the fallback if the user has no home folder."""
    root = os.environ.get("XDG_CACHE_HOME")
    try:
        return Path(root or Path.home() / ".cache") / "cdpr"
    except RuntimeError:  # no HOME, and a uid unknown to the system
        return fallback()


@lru_cache(maxsize=1)
def fallback() -> Path:
    """Return the folder that replaces the user's cache: one per user, in the folder for temporary files.

    Its content is executed, so it must belong to the user and be closed to others. Otherwise a new folder replaces it,
    which is removed when this process ends.

    Raises:
        OutputError: if no folder for temporary files can be written.
    """
    try:
        path = Path(tempfile.gettempdir()) / f"cdpr-{os.geteuid()}"
    except OSError as error:
        raise _unwritable(Path("/tmp"), error) from error
    with contextlib.suppress(OSError):
        path.mkdir(mode=0o700)
    with contextlib.suppress(OSError):
        found = path.lstat()  # not a link, which others can make
        if stat.S_ISDIR(found.st_mode) and found.st_uid == os.geteuid() and not found.st_mode & 0o077:
            return path
    try:
        path = Path(tempfile.mkdtemp(prefix=PASSING))
    except OSError as error:
        raise _unwritable(path, error) from error
    atexit.register(shutil.rmtree, path, ignore_errors=True)
    return path


def _unwritable(path: Path, error: OSError) -> OutputError:
    return OutputError(
        f"{path}: compiled FMUs cannot be kept there: {error.strerror or error}; set XDG_CACHE_HOME to a folder that "
        "can be written"
    )
