"""Files written in one step: no half of one ever bears the name. Where one must not fail, room is kept for it."""

from __future__ import annotations

import contextlib
import errno
import os
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from cdpr.errors import OutputError
from cdpr.locks import Lock, lock, open_to_lock

GOES_ON = "its run, or a repair of it, is still going on; wait for it, or end it"
LOCK_SECONDS = 10.0  # that a new run waits for a repair that looks into its folder, which takes milliseconds


def is_name(name: object) -> bool:
    """Whether a file may have this name: a text, or a path, that the system can write."""
    try:
        return b"\0" not in os.fsencode(name)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False


def replace(path: Path, content: str | bytes) -> None:
    """Write a file, over an older one of its name; text as UTF-8. Raises OutputError."""
    with replacing(path) as file:
        file.write(content.encode() if isinstance(content, str) else content)


def create(path: Path, content: str | bytes) -> None:
    """Write a new file in one step: whole, or not there. Raises FileExistsError, and OSError as the system does."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)
        try:
            os.link(temporary, path)
        except FileExistsError:
            raise
        except OSError:  # a file system without links
            if os.path.lexists(path):
                raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path)) from None
            os.replace(temporary, path)
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def replace_markup(path: Path, text: str) -> None:
    """The same of HTML and SVG, in which what UTF-8 has no bytes for stands as a character reference."""
    replace(path, text.encode(errors="xmlcharrefreplace"))


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """Open a file that takes the name `path` once all of it is written. Raises OutputError."""
    temporary = path.with_name(f"{path.name}.tmp")
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):  # a device: the file would take its place
            raise OutputError(f"{path}: cannot be written: it is no regular file")
        with temporary.open("wb") as file:
            yield file
        os.replace(temporary, path)
    except OSError as error:
        raise unwritable(path, error) from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def require_process(process: int, path: Path) -> None:
    """Raise OutputError in any process but the one with this number, which opened `path`: a fork must not write it."""
    if os.getpid() != process:
        raise OutputError(
            f"{path}: only the process that began this run may write it; begin another run after the fork"
        )


class Reserved:
    """Room on the disk for a file that must be written in any case, kept until it is: beside it, as NAME.new.

    The room is locked while this process lives: so others see that it does.

    Attributes:
        path: the file to be.
    """

    def __init__(self, path: Path, size: int) -> None:
        """Keep `size` bytes; NAME.new may be there. Raises OutputError."""
        try:
            self._take(path, open_to_lock(beside(path)), LOCK_SECONDS)
            if size:
                os.posix_fallocate(self._file, 0, size)
        except OSError as error:
            raise unwritable(path, error) from error

    @classmethod
    def left(cls, path: Path) -> Reserved | None:
        """Take over the room that another process left, None where there is none.

        Raises OutputError where that process lives or the room is no file.
        """
        room = cls.__new__(cls)
        try:
            try:
                file = open_to_lock(beside(path), os.O_RDWR)
            except PermissionError:  # whether that process lives can be told all the same
                file = open_to_lock(beside(path), os.O_RDONLY)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise unwritable(path, error) from error
        room._take(path, file, 0.0)
        return room

    def _take(self, path: Path, file: int, wait: float) -> None:
        self.path, self._room, self._file = path, beside(path), file
        self._close = weakref.finalize(self, os.close, file)
        if lock(file, wait) is Lock.ANOTHERS:
            raise OutputError(f"{path.parent}: {GOES_ON}")

    def write(self, content: bytes) -> None:
        """Write the file, over an older one; once it is written, do nothing. Raises OutputError; try less then."""
        if not self._close.alive or self._written():
            return
        try:
            done = 0
            while done < len(content):
                done += os.pwrite(self._file, content[done:], done)
            os.ftruncate(self._file, done)
            os.replace(self._room, self.path)
        except OSError as error:
            raise unwritable(self.path, error) from error
        self._close()

    def _written(self) -> bool:
        """Tell whether the room has become the file: a signal may have come just then."""
        try:
            return os.path.samestat(os.fstat(self._file), os.stat(self.path))
        except OSError:
            return False

    def release(self) -> None:
        """Give the room back."""
        with contextlib.suppress(OSError):
            self._room.unlink()
        self.close()

    def close(self) -> None:
        """Let others have the room."""
        self._close()


def beside(path: Path) -> Path:
    """Return where room is kept for a file."""
    return path.with_name(f"{path.name}.new")


def make_folder(folder: Path) -> None:
    """Make a folder with all above it, where it is not there. Raises OutputError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(folder, error) from error


def unwritable(path: Path, error: OSError) -> OutputError:
    """Return the error that says that `path` cannot be written, and why."""
    return OutputError(f"{path}: cannot be written: {error.strerror or error}")
