"""Trust in native code of FMUs.

An FMU contains native code with the permissions of its user. It runs only if the scenario contains its sha256, if it is
in the user's list, or if the user allows it for this run; nothing else in a scenario can allow it.
"""

from __future__ import annotations

import os
import re
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from cdpr.base import ownership
from cdpr.base.errors import FmuError, OutputError
from cdpr.base.locks import Lock, lock, open_to_lock
from cdpr.base.problems import printable
from cdpr.fmu.read.archive import Archive

_allowed: ContextVar[bool] = ContextVar("trust_fmu", default=False)
HEADER = "# FMUs whose native code cdpr may run: sha256, name. Written by 'cdpr fmu trust' and 'cdpr fmu export'."
MOST = 2**22  # bytes of the list: fifty thousand FMUs
LOCK_SECONDS = 10.0  # longest wait for other writers of the list; each takes milliseconds


@contextmanager
def any_fmu() -> Iterator[None]:
    """Trust every FMU inside the block: the implementation of `--trust-fmu`."""
    token = _allowed.set(True)
    try:
        yield
    finally:
        _allowed.reset(token)


def list_path() -> Path:
    """Return the path of the user's list."""
    root = os.environ.get("XDG_CONFIG_HOME")
    try:
        return (Path(root) if root else Path.home() / ".config") / "cdpr" / "trusted_fmus"
    except RuntimeError as error:  # no HOME, and an unknown uid
        raise FmuError(f"no folder for the list of trusted FMUs ({error}); set XDG_CONFIG_HOME") from None


def trusted() -> dict[str, str]:
    """Return the user's list, name by sha256.

    Raises:
        FmuError: if it cannot be read or is malformed.
    """
    path = list_path()
    found = {}
    for number, line in enumerate(_lines(path), 1):
        if not line.strip() or line.startswith("#"):
            continue
        match = re.fullmatch(r"([0-9a-f]{64})(?:  (.*))?", line)
        if match is None:
            raise FmuError(f"{path}:{number}: expected a sha256 and a name, got {line[:80]!r}; correct or remove it")
        found[match[1]] = match[2] or ""
    return found


def add(sha256: str, name: str) -> None:
    """Add an FMU to the user's list.

    Raises:
        FmuError: if the list is malformed.
        OutputError: if it cannot be written.
    """
    if sha256 in trusted():
        return
    with _locked() as path:
        if sha256 not in trusted():  # another process may have added it
            _write(path, [*(_lines(path) or [HEADER]), f"{sha256}  {printable(name)}"])


def remove(sha256: str) -> None:
    """Remove an FMU from the user's list.

    Raises:
        FmuError: if it is not in the list.
    """
    if sha256 not in trusted():
        raise FmuError(f"{sha256}: is not on the list of trusted FMUs, {list_path()}")
    with _locked() as path:
        _write(path, [line for line in _lines(path) if not line.startswith(sha256)])


def require_trust(archive: Archive, pinned: str | None) -> None:
    """Return if the native code of an FMU may run; `pinned` is the scenario's sha256.

    Raises:
        FmuError: otherwise, and always if the file differs from the pinned one.
    """
    if pinned is not None:
        if pinned.lower() == archive.sha256:
            return
        raise FmuError(
            f"{archive.path}: is not the file that the scenario pins: its sha256 is {archive.sha256}, "
            f"pinned is {pinned}. If the change is intended, pin the new checksum."
        )
    if _allowed.get() or archive.sha256 in trusted():
        return
    raise FmuError(
        f"{archive.path}: contains native code, which runs with your permissions, and is not trusted. "
        f"If you trust it, pin it in the scenario beside 'file':\n  sha256: {archive.sha256}\n"
        f"or run 'cdpr fmu trust {archive.path}' once, or give --trust-fmu for one run."
    )


def _lines(path: Path) -> list[str]:
    """Return the lines of the list, none if it does not exist; checks and content use the same open file."""
    try:
        with open(path, "rb", opener=_without_waiting) as file:
            if fault := _fault(os.fstat(file.fileno()), path.parent):
                raise FmuError(f"{path}: {fault}; only you may write this list: correct or remove it")
            content = file.read(MOST + 1)
        if len(content) > MOST:
            raise ValueError(f"it has more than {MOST // 2**20} MiB")
        return content.decode("utf-8").splitlines()
    except FileNotFoundError:
        return []
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FmuError(f"{path}: the list of trusted FMUs cannot be read: {reason}; correct or remove it") from None


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | os.O_NONBLOCK)  # a FIFO would wait for a writer


def _fault(about: os.stat_result, folder: Path) -> str:
    """Return what is wrong with the list and the folders above it, "" if nothing."""
    if not stat.S_ISREG(about.st_mode):
        return "the list of trusted FMUs is not a regular file"
    return ownership.fault_of(about, "the list of trusted FMUs") or ownership.fault(folder)


@contextmanager
def _locked() -> Iterator[Path]:
    """Lock the list, and yield its path."""
    path = list_path()
    try:
        ownership.make_private(path.parent, path.parent)
        # A separate file: the list is replaced, and NFS cannot lock folders.
        file = open_to_lock(path.with_name(f"{path.name}.lock"), mode=0o600)
    except OSError as error:
        raise _unwritable(path, error) from None
    try:
        if lock(file, LOCK_SECONDS) is Lock.ANOTHERS:
            raise OutputError(f"{path}: another process has locked the list of trusted FMUs; stop that process")
        yield path
    finally:
        os.close(file)


def _write(path: Path, lines: list[str]) -> None:
    """Replace the list in one step, readable and writable for this user alone."""
    try:
        descriptor, temporary = tempfile.mkstemp(prefix=f"{path.name}.", dir=path.parent)
        try:
            with open(descriptor, "w", encoding="utf-8") as file:
                file.writelines(f"{line}\n" for line in lines)
            os.replace(temporary, path)
        except OSError:
            os.unlink(temporary)
            raise
    except OSError as error:
        raise _unwritable(path, error) from None


def _unwritable(path: Path, error: OSError) -> OutputError:
    return OutputError(f"{path}: the list of trusted FMUs cannot be written: {error.strerror or error}")
