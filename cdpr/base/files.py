"""Reading of user files: regular files only, up to a size limit."""

from __future__ import annotations

import os
import stat
import time

from cdpr.base.nearest import did_you_mean

MAX_BYTES = 256 * 1024
SECONDS = 10.0  # default limit of CPU time
MAX_FAULTS = 10  # reported of one file: a wrong column is wrong in every row
CHUNK = 2**18  # bytes: reading the whole limit at once would allocate it even for small files


class UnreadableError(Exception):
    """Unreadable file; the message follows the position of the reference."""


class ContentError(Exception):
    """Invalid content of a file: list of (line, column, text), starting at 1; column 0 means the whole line."""

    def __init__(self, faults: list[tuple[int, int, str]]) -> None:
        super().__init__(str(faults))
        self.faults = faults


def text_of(content: bytes, limit: int) -> str:
    """Return UTF-8 content of at most `limit` bytes as text; raise ContentError otherwise."""
    if len(content) > limit:
        raise ContentError([(1, 0, f"the file is larger than {limit // 1024**2} MiB")])
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ContentError([(line, 0, "this is not a text in UTF-8")]) from None


class CpuBudget:
    """Limit of the CPU time of this thread for loading one file, from reading to use."""

    def __init__(
        self, path: str = "", remedy: str = "simplify it", spent: float = 0.0, seconds: float = SECONDS
    ) -> None:
        """Start the clock.

        Args:
            path: the file; empty if the caller names it.
            remedy: advice for the user if the limit is exceeded.
            spent: CPU time of earlier parts, s.
            seconds: limit for all parts together, s.
        """
        self._seconds = seconds
        self._name, self._remedy = f"'{path}': " if path else "", remedy
        self._start = time.thread_time() - spent

    @property
    def spent(self) -> float:
        """CPU time so far, s."""
        return time.thread_time() - self._start

    def check(self) -> None:
        """Raise UnreadableError if the limit is exceeded."""
        if self.spent > self._seconds:
            text = f"reading it takes more than {self._seconds:g} s of CPU time: {self._remedy}"
            raise UnreadableError(f"{self._name}{text}")


def read(path: str, limit: int = MAX_BYTES, endings: tuple[str, ...] = (".yaml", ".yml")) -> bytes:
    """Return the content of a regular file, at most `limit` + 1 bytes.

    FIFOs and devices are never opened, because opening may block or have side effects.

    Args:
        path: the file.
        limit: largest allowed size, bytes.
        endings: file name endings of suggestions if the file does not exist.

    Raises:
        UnreadableError: if it cannot be read.
    """
    try:
        _refuse_special(os.stat(path), path)
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0))
        with open(descriptor, "rb") as file:
            _refuse_special(os.fstat(descriptor), path)  # it may have been replaced in the meantime
            parts, left = list[bytes](), limit + 1
            while left and (part := file.read(min(left, CHUNK))):
                parts.append(part)
                left -= len(part)
            return b"".join(parts)
    except FileNotFoundError:
        if os.path.islink(path):
            raise UnreadableError(f"'{path}' is a link to '{os.readlink(path)}', which does not exist") from None
        raise UnreadableError(f"there is no file '{path}'{_suggestion(path, endings)}") from None
    except (OSError, ValueError) as error:  # ValueError: NUL in the name
        reason = getattr(error, "strerror", None) or str(error)
        raise UnreadableError(f"cannot read '{path}': {reason}") from None


def seen_from(folder: str | os.PathLike[str], path: str | os.PathLike[str]) -> str:
    """Return the name of a file relative to a folder.

    Symbolic links to folders are resolved first, because `..` refers to the parent of the link's target.
    """
    above, name = os.path.split(path)
    return os.path.relpath(os.path.join(os.path.realpath(above), name), os.path.realpath(folder))


def _refuse_special(status: os.stat_result, path: str) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise UnreadableError(f"'{path}' is a folder; expected a file")
    if not stat.S_ISREG(status.st_mode):
        raise UnreadableError(f"'{path}' is not a regular file")


def _suggestion(path: str, endings: tuple[str, ...]) -> str:
    """Return a hint with the most similar file in the folder, or that the folder is missing."""
    folder, name = os.path.split(path)
    try:
        names = [entry for entry in os.listdir(folder or ".") if entry.endswith(endings)]
    except OSError:
        return f": there is no folder '{folder}'"
    if hint := did_you_mean(name, names):
        return f": {hint.strip()}"
    return f"; files there: {', '.join(sorted(names)[:10])}" if names else ""
