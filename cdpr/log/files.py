"""Atomic writing of files, and reserved disk space for files whose writing must not fail."""

from __future__ import annotations

import contextlib
import errno
import itertools
import os
import re
import weakref
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import BinaryIO

from cdpr.base.errors import OutputError
from cdpr.base.incomplete import NAME_LENGTH, incomplete
from cdpr.base.locks import Lock, lock, open_to_lock
from cdpr.base.problems import shown

GOES_ON = "its run, or a repair of it, is still going on; wait for it, or end it"
NAME_OR_FORCE = "choose another --out, or --force"  # remedy of commands if a file exists
NAME_OR_FORCE_IN_PYTHON = "choose another name, or force=True"
NAME_MAX = 255  # bytes of a file name, on most file systems
LOCK_SECONDS = 10.0  # s that a new run waits for a repair to inspect its folder, which takes milliseconds


class ExistingFileError(OutputError):
    """Name of a file that another process has created meanwhile; the text names the file that was written instead."""


def is_name(name: object) -> bool:
    """Return True if `name` is a text or path that is valid as a file name."""
    try:
        return b"\0" not in os.fsencode(name)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False


def output_path(name: object, place: str, kind: str = "file") -> Path:
    """Return the path of a file or folder to write, given at `place` of a call.

    Raises:
        OutputError: if `name` is no valid name.
    """
    if not isinstance(name, str | os.PathLike) or not is_name(name):
        raise OutputError(f"{place}: expected the name of a {kind}, got {shown(name)}")
    path = Path(name)
    try:
        path.exists()  # raises if the name is too long
    except OSError as error:
        raise unwritable(path, error) from error
    return path


def name_from(text: str) -> str:
    """Return a file name, without folder and ending, from a name: other characters become underscores."""
    return re.sub(r"[^\w.-]+", "_", text).lstrip(".-")[:64] or "unnamed"


def replace(path: Path, content: str | bytes, force: bool = True) -> None:
    """Write or replace a file; text is encoded as UTF-8. Without `force`, an existing file is kept, as in `replacing`.

    Raises:
        OutputError: if it cannot be written.
    """
    with replacing(path, force) as file:
        file.write(content.encode() if isinstance(content, str) else content)


def replace_all(folder: Path, contents: Mapping[str, str | bytes], force: bool = True) -> None:
    """Write or replace files of a folder, which is created if necessary. Without `force`, existing ones are kept.

    Raises:
        OutputError: if one cannot be written, or after all were written, for existing ones.
    """
    make_folder(folder)
    existing = []
    for name, content in contents.items():
        try:
            replace(folder / name, content, force)
        except ExistingFileError as error:
            existing.append(str(error))
    if existing:
        raise ExistingFileError("\n".join(existing))


def require_new(path: Path, force: bool, remedy: str = NAME_OR_FORCE) -> None:
    """Raise OutputError with the remedy if a file or link exists, unless `force` allows to replace it.

    A folder or device cannot be replaced.
    """
    if kind := _not_a_file(path):
        raise OutputError(f"'{path}' is {kind}; choose another name")
    if not force and os.path.lexists(path):
        raise OutputError(f"'{path}' already exists and is not overwritten; {remedy}")


def create(path: Path, content: str | bytes) -> None:
    """Create a file atomically.

    Raises:
        FileExistsError: if it exists.
        OSError: if it cannot be written.
    """
    with incomplete(path) as temporary:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)
        _name(temporary, path)


def _name(temporary: Path, path: Path) -> None:
    """Give a complete file its final name; raise FileExistsError if that exists."""
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise
    except OSError:  # file system without hard links
        if os.path.lexists(path):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path)) from None
        os.replace(temporary, path)


def _name_beside(temporary: Path, path: Path) -> Path:
    """Give a complete file the first free name of NAME-2.END, NAME-3.END, ... beside `path`, and return it."""
    long = len(os.fsencode(path.name)) > NAME_MAX - 10
    for number in itertools.count(2):
        other = path.with_name(f"{path.stem[:NAME_LENGTH] if long else path.stem}-{number}{path.suffix}")
        with contextlib.suppress(FileExistsError):
            _name(temporary, other)
            return other
    raise AssertionError("unreachable")


def replace_markup(path: Path, text: str, force: bool = True) -> None:
    """Write or replace an HTML or SVG file, as `replace` does."""
    replace(path, markup(text), force)


def markup(text: str) -> bytes:
    """Encode HTML or SVG; characters without UTF-8 encoding become character references."""
    return text.encode(errors="xmlcharrefreplace")


@contextlib.contextmanager
def replacing(path: Path, force: bool = True) -> Iterator[BinaryIO]:
    """Open a temporary file that is renamed to `path` after it was written; a symbolic link is replaced itself.

    Raises:
        OutputError: if it cannot be written.
        ExistingFileError: if `path` exists, without `force`. The content is then in NAME-2.END beside it, because
            commands check their output files before they compute: another process has created this one meanwhile.
    """
    try:
        if kind := _not_a_file(path):  # a file would replace the device
            raise OutputError(f"{path}: cannot be written: it is {kind}")
        with incomplete(path) as temporary:
            with temporary.open("w+b") as file:
                yield file
            if force:
                os.replace(temporary, path)
                return
            try:
                _name(temporary, path)
            except FileExistsError:
                other = _name_beside(temporary, path)
                raise ExistingFileError(
                    f"'{path}' was created meanwhile and is not overwritten; this result was written to '{other}'"
                ) from None
    except OSError as error:
        raise unwritable(path, error) from error


def require_process(process: int, path: Path) -> None:
    """Raise OutputError in any process other than `process`, which opened `path`: forks must not write it."""
    if os.getpid() != process:
        raise OutputError(
            f"{path}: only the process that began this run may write it; begin another run after the fork"
        )


def _not_a_file(path: Path) -> str:
    """Return the kind of a folder or device in place of a file; "" for files and unused names."""
    if not os.path.exists(path) or os.path.isfile(path):
        return ""
    return "a folder" if os.path.isdir(path) else "not a regular file"


class Reserved:
    """Reserved disk space for a file that must be written: a file NAME.new next to it.

    The file is locked while this process lives, so that others can detect that.

    Attributes:
        path: final file.
    """

    def __init__(self, path: Path, size: int) -> None:
        """Reserve `size` bytes; NAME.new may exist.

        Raises:
            OutputError: if the space is not available or in use.
        """
        try:
            self._take(path, open_to_lock(beside(path)), LOCK_SECONDS)
            if size:
                os.posix_fallocate(self._file, 0, size)
        except OSError as error:
            raise unwritable(path, error) from error

    @classmethod
    def left(cls, path: Path) -> Reserved | None:
        """Take over the space reserved by another process; return None if there is none.

        Raises:
            OutputError: if that process lives, or NAME.new is not a file.
        """
        reserved = cls.__new__(cls)
        try:
            try:
                file = open_to_lock(beside(path), os.O_RDWR)
            except PermissionError:  # the lock can be tested without write permission
                file = open_to_lock(beside(path), os.O_RDONLY)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise unwritable(path, error) from error
        reserved._take(path, file, 0.0)
        return reserved

    def _take(self, path: Path, file: int, wait: float) -> None:
        self.path, self._temporary, self._file = path, beside(path), file
        self._close = weakref.finalize(self, os.close, file)
        if lock(file, wait) is Lock.ANOTHERS:
            raise OutputError(f"{path.parent}: {GOES_ON}")

    def write(self, content: bytes) -> None:
        """Write the file or replace an older one; do nothing if it is already written.

        Raises:
            OutputError: if it cannot be written; a smaller content may succeed.
        """
        if not self._close.alive or self._written():
            return
        try:
            done = 0
            while done < len(content):
                done += os.pwrite(self._file, content[done:], done)
            os.ftruncate(self._file, done)
            os.replace(self._temporary, self.path)
        except OSError as error:
            raise unwritable(self.path, error) from error
        self._close()

    def _written(self) -> bool:
        """Return True if the reserved file was already renamed, such as before a signal."""
        try:
            return os.path.samestat(os.fstat(self._file), os.stat(self.path))
        except OSError:
            return False

    def release(self) -> None:
        """Free the space."""
        with contextlib.suppress(OSError):
            self._temporary.unlink()
        self.close()

    def close(self) -> None:
        """Release the lock."""
        self._close()


def beside(path: Path) -> Path:
    """Return the path of the reserved space of a file."""
    return path.with_name(f"{path.name}.new")


def make_folder(folder: Path) -> None:
    """Create a folder and its parents if necessary.

    Raises:
        OutputError: if it cannot be created.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        raise OutputError(f"{folder}: cannot be written: it is a file, not a folder") from error
    except OSError as error:
        raise unwritable(folder, error) from error


def unwritable(path: Path, error: OSError) -> OutputError:
    """Return the error for a path that cannot be written, with the reason."""
    return OutputError(f"{path}: cannot be written: {error.strerror or error}")
