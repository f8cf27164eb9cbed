"""Files written in one step: no half of one ever bears the name. Where one must not fail, room is kept for it."""

from __future__ import annotations

import contextlib
import fcntl
import os
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from cdpr.errors import OutputError


def replace(path: Path, content: str | bytes) -> None:
    """Write a file, over an older one of its name; text as UTF-8. Raises OutputError."""
    with replacing(path) as file:
        file.write(content.encode() if isinstance(content, str) else content)


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """Open a file that takes the name `path` once all of it is written. Raises OutputError."""
    temporary = path.with_name(f"{path.name}.tmp")
    try:
        with temporary.open("wb") as file:
            yield file
        os.replace(temporary, path)
    except OSError as error:
        raise unwritable(path, error) from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


class Reserved:
    """Room on the disk for a file that must be written in any case, kept until it is: beside it, as NAME.new.

    The room is locked while this process lives.

    Attributes:
        path: the file to be.
    """

    def __init__(self, path: Path, size: int) -> None:
        """Keep `size` bytes; NAME.new may be there. Raises OutputError."""
        self.path = path
        self._room = beside(path)
        try:
            self._file = os.open(self._room, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
            self._close = weakref.finalize(self, os.close, self._file)
            with contextlib.suppress(OSError):  # a file system without locks
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if size:
                os.posix_fallocate(self._file, 0, size)
        except OSError as error:
            raise unwritable(path, error) from error

    def write(self, content: bytes) -> None:
        """Write the file, over an older one. Raises OutputError; less may be tried then."""
        try:
            done = 0
            while done < len(content):
                done += os.pwrite(self._file, content[done:], done)
            os.ftruncate(self._file, done)
            os.replace(self._room, self.path)
        except OSError as error:
            raise unwritable(self.path, error) from error
        self._close()

    def release(self) -> None:
        """Give the room back."""
        with contextlib.suppress(OSError):
            self._room.unlink()
        self._close()


def beside(path: Path) -> Path:
    """Return where room is kept for a file."""
    return path.with_name(f"{path.name}.new")


def reserved(path: Path) -> bool:
    """Tell whether a process that lives keeps room for a file."""
    try:
        with beside(path).open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:  # there is none, or nobody can tell
        return False
    return False


def make_folder(folder: Path) -> None:
    """Make a folder with all above it, where it is not there. Raises OutputError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(folder, error) from error


def unwritable(path: Path, error: OSError) -> OutputError:
    """Return the error that says that `path` cannot be written, and why."""
    return OutputError(f"{path}: cannot be written: {error.strerror or error}")
