"""Whose native code may run.

An FMU brings native code, which can do whatever its user can. It runs only if the scenario pins its sha256, if it is in
the user's list, or if the user said so for this run; nothing else in a scenario can allow it.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from cdpr.errors import FmuError, OutputError
from cdpr.fmu.archive import Archive

_allowed: ContextVar[bool] = ContextVar("trust_fmu", default=False)
HEADER = "# FMUs whose native code cdpr may run: sha256, name. Written by 'cdpr fmu trust' and 'cdpr fmu export'.\n"


@contextmanager
def any_fmu() -> Iterator[None]:
    """Trust every FMU inside the block: what `--trust-fmu` does."""
    token = _allowed.set(True)
    try:
        yield
    finally:
        _allowed.reset(token)


def list_path() -> Path:
    """Where the user's list lies."""
    root = os.environ.get("XDG_CONFIG_HOME")
    try:
        return (Path(root) if root else Path.home() / ".config") / "cdpr" / "trusted_fmus"
    except RuntimeError as error:  # no HOME, and a uid that the system does not know
        raise FmuError(f"there is no place for the list of trusted FMUs ({error}); set XDG_CONFIG_HOME") from None


def trusted() -> dict[str, str]:
    """Return the user's list, name by sha256. Raises FmuError where it cannot be read or is malformed."""
    path = list_path()
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FmuError(f"{path}: the list of trusted FMUs cannot be read: {reason}; mend or remove it") from None
    found = {}
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.startswith("#"):
            continue
        match = re.fullmatch(r"([0-9a-f]{64})(?:  (.*))?", line)
        if match is None:
            raise FmuError(f"{path}:{number}: a sha256 and a name are expected, got {line[:80]!r}; mend or remove it")
        found[match[1]] = match[2] or ""
    return found


def add(sha256: str, name: str) -> None:
    """Put an FMU on the user's list. Raises FmuError where the list is malformed, OutputError where not writable."""
    if sha256 in trusted():
        return
    shown = re.sub(r"[^ -~]", "?", name)
    _write([*_lines(), f"{sha256}  {shown}\n"])


def remove(sha256: str) -> None:
    """Take an FMU off the user's list. Raises FmuError where it is not there."""
    if sha256 not in trusted():
        raise FmuError(f"{sha256}: is not on the list of trusted FMUs, {list_path()}")
    _write([line for line in _lines() if not line.startswith(sha256)])


def require_trust(archive: Archive, pinned: str | None) -> None:
    """Return if the native code of an FMU may run; `pinned` is the sha256 that the scenario gives.

    Raises FmuError otherwise, and wherever the file is not the one that is pinned.
    """
    if pinned is not None:
        if pinned.lower() == archive.sha256:
            return
        raise FmuError(
            f"{archive.path}: is not the file that the scenario pins: its sha256 is {archive.sha256}, "
            f"pinned is {pinned}. If the change is meant, pin the new one."
        )
    if _allowed.get() or archive.sha256 in trusted():
        return
    raise FmuError(
        f"{archive.path}: holds native code, which can do whatever you can, and nobody said that you trust it. If you "
        f"do, pin it in the scenario beside 'file':\n  sha256: {archive.sha256}\n"
        f"or run 'cdpr fmu trust {archive.path}' once, or give --trust-fmu for one run."
    )


def _lines() -> list[str]:
    path = list_path()
    return path.read_text(encoding="utf-8").splitlines(keepends=True) if path.exists() else [HEADER]


def _write(lines: list[str]) -> None:
    path = list_path()
    temporary = path.with_name(f"{path.name}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_text("".join(lines), encoding="utf-8")
        os.replace(temporary, path)
    except OSError as error:
        raise OutputError(f"{path}: the list of trusted FMUs cannot be written: {error.strerror or error}") from None
