"""Cache of compiled FMU libraries, their objects and finished FMUs in the user's cache folder."""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from cdpr.base import ownership
from cdpr.base.checksums import checksum
from cdpr.base.errors import OutputError
from cdpr.base.locks import lock, open_to_lock
from cdpr.base.temporary import TemporaryFolder, sweep
from cdpr.base.user_folders import user_cache
from cdpr.fmu.export.description import IDENTIFIER

COMPILING = "compiling-"  # first part of the names of folders in which compilers work
TIMEOUT = 1800.0  # s; typical are a few, with zig a minute or two at first, and ten times that on a busy machine


def kept(
    command: Sequence[str], files: Mapping[str, bytes], ending: str, number: int, make: Callable[[Path], Path]
) -> bytes:
    """Return the file that a compiler makes of `files`, contents by name; from the cache if present.

    If another process is making the file, wait for it.

    Args:
        command: the compiler's command, for the name in the cache only.
        files: content of the compiled files, by name.
        ending: ending of the file's name.
        number: number of such files that the cache keeps.
        make: function that makes the file in a new folder, and returns its path.
    """
    digest = hashlib.sha256(repr((command, platform.machine())).encode())
    for name, content in files.items():
        digest.update(name.encode() + b"\0" + content)
    folder = fmu_cache()
    begin = f"{IDENTIFIER}-{digest.hexdigest()[:32]}-"
    if (known := _known(folder, begin, ending)) is not None:
        return known
    with _locked(folder / f"{begin}lock.tmp"):
        if (known := _known(folder, begin, ending)) is not None:
            return known
        with TemporaryFolder(COMPILING, str(folder)) as place:
            built = make(Path(place.path))
            built.chmod(0o600)
            content = built.read_bytes()
            os.replace(built, folder / f"{begin}{checksum(content)}{ending}")
    keep_newest(folder, ending, number)
    return content


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold a lock between processes; without one if the file system has none, or another holds it for too long."""
    file = open_to_lock(path, mode=0o600)
    try:
        lock(file, TIMEOUT)
        yield
    finally:
        path.unlink(missing_ok=True)  # who waits for it finds what was made
        os.close(file)


def _known(folder: Path, begin: str, ending: str) -> bytes | None:
    """Return the content of a usable file of the cache whose name has this begin and ending; None if there is none."""
    found = (_cached(path) for path in folder.glob(f"{begin}*{ending}"))
    return next((content for content in found if content is not None), None)


def _cached(path: Path) -> bytes | None:
    """Return the content of a library with its checksum in the file name; None, with a warning, if not usable."""
    try:
        content = ownership.read_private(path)
    except FileNotFoundError:  # another process has removed it
        return None
    except OSError as error:
        reason = str(error)
    else:
        if checksum(content) == path.stem.rpartition("-")[2]:
            return content
        reason = f"{path} is damaged"
    warnings.warn(f"{reason}: it is not used, and compiled again", stacklevel=2)
    with contextlib.suppress(OSError):
        path.unlink()
    return None


def fmu_cache() -> Path:
    """Return the folder for libraries and FMUs in the user's cache, created if necessary.

    Raises:
        OutputError: if it cannot be written, or other users can write there: its files are executed.
    """
    root = user_cache()
    folder = root / "fmu"
    try:
        ownership.make_private(folder, root)
        with tempfile.TemporaryFile(dir=folder):
            pass
        found = ownership.fault(folder)
    except OSError as error:
        raise OutputError(
            f"{folder}: cannot be written: {error.strerror}; set XDG_CACHE_HOME to a folder that can"
        ) from error
    if found:
        raise OutputError(f"{folder}: is not used: {found}; or set XDG_CACHE_HOME to a folder of your own")
    sweep(str(folder), COMPILING)  # of exports that were killed
    for path in folder.glob("*.tmp"):
        with contextlib.suppress(OSError):
            if time.time() - path.stat().st_mtime > TIMEOUT:
                path.unlink()
    return folder


def keep_newest(folder: Path, ending: str, number: int) -> None:
    """Remove all but the newest files with this ending."""
    with contextlib.suppress(OSError):  # another process may do the same
        found = sorted(folder.glob(f"*{ending}"), key=lambda path: path.stat().st_mtime, reverse=True)
        for path in found[number:]:
            path.unlink()
