"""Compiles the C source of the plant with the system's compiler, once for each state of the source."""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from cdpr import ownership
from cdpr.checksums import checksum
from cdpr.errors import OutputError, PluginError
from cdpr.fmu.export.control import NOBODY
from cdpr.fmu.export.description import IDENTIFIER
from cdpr.fmu.export.parts import part_sources
from cdpr.user_cache import user_cache

SOURCE = Path(__file__).parent / "source"
STANDARD = SOURCE.with_name("fmi")  # the headers of FMI, which are not ours

# The plant's arithmetic must be that of `reference` operation by operation: products are not fused with sums. Nothing
# but the functions of FMI can be seen from outside, so that several such libraries live in one process.
FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off")

KEPT = 20  # libraries of other states of the source, or by other compilers
TIMEOUT = 120.0  # s; it takes about one

# How FMI 2 calls a platform; FMI 3 says MACHINE-linux.
FOLDERS = {"x86_64": "linux64", "i686": "linux32"}

# What there can be binaries for: where the exporter runs, and what it has a cross compiler for.
NATIVE, WINDOWS = "native", "win64"
PLATFORMS = (NATIVE, WINDOWS)
CROSS = "x86_64-w64-mingw32-gcc"

# Windows: numbers read and printed as C99 says, no further library to go with it, no time in it: the same bytes.
CROSS_FLAGS = ("-D__USE_MINGW_ANSI_STDIO=1", "-static-libgcc", "-s", "-Wl,--no-insert-timestamp")

REMEDY = "give --source-only for an FMU with its C source alone, to be compiled where it is used"


def sources() -> dict[str, bytes]:
    """Return all C files and headers by their names, in this order: the plant's, those of parts of cables, a table."""
    own = [path for folder in (SOURCE, STANDARD) for path in folder.iterdir() if path.suffix in (".c", ".h")]
    return dict(sorted({**{path.name: path.read_bytes() for path in own}, **part_sources(), **NOBODY}.items()))


@dataclass(frozen=True)
class Target:
    """A platform for which there can be a binary.

    Attributes:
        folder: of its binaries inside an FMU.
        command: the C compiler, its program as a whole path.
        flags: what it needs beside those for all.
    """

    folder: str
    ending: str
    command: tuple[str, ...]
    flags: tuple[str, ...] = ()


def target(name: str, fmi: int) -> Target:
    """Return one of PLATFORMS; PluginError where there is no compiler for it, or FMI has no name for it."""
    if name == WINDOWS:
        program = shutil.which(CROSS)
        if program is None:
            raise PluginError(
                f"there is no compiler for {WINDOWS}: '{CROSS}' is not found; install it (such as the package "
                f"gcc-mingw-w64-x86-64), leave --platform {WINDOWS} out, or {REMEDY}"
            )
        return Target("win64" if fmi == 2 else "x86_64-windows", ".dll", (program,), CROSS_FLAGS)
    machine = platform.machine()
    if sys.platform != "linux" or (fmi == 2 and machine not in FOLDERS):
        raise PluginError(f"FMI {fmi} binaries are not made on {sys.platform} {machine}: {REMEDY}")
    return Target(FOLDERS[machine] if fmi == 2 else f"{machine}-linux", ".so", tuple(compiler()))


def compiler() -> list[str]:
    """Return the command of the C compiler for this platform, $CC or cc, its program as a whole path."""
    given = os.environ.get("CC", "").strip() or "cc"
    try:
        words = shlex.split(given)
    except ValueError as error:
        raise PluginError(
            f"CC is no command: {error}, got {given!r}; set it to one, such as gcc, or {REMEDY}"
        ) from None
    program = shutil.which(words[0])
    if program is None:
        raise PluginError(
            f"there is no C compiler: '{words[0]}' is not found; install one (such as the package gcc with libc6-dev), "
            f"set CC, or {REMEDY}"
        )
    return [program, *words[1:]]


def library(files: Mapping[str, bytes], flags: Sequence[str] = FLAGS, goal: Target | None = None) -> bytes:
    """Return the shared library of the C files among `files`, contents by name; from the user's cache if there.

    It is for this platform unless said; the cache tells compilers apart by their names, flags and machines.
    """
    goal = goal or Target("", ".so", tuple(compiler()))
    command = [*goal.command, *flags, *goal.flags]
    digest = hashlib.sha256(repr((command, platform.machine())).encode())
    for name, content in files.items():
        digest.update(name.encode() + b"\0" + content)
    folder = fmu_cache()
    begin = f"{IDENTIFIER}-{digest.hexdigest()[:32]}-"
    for cached in folder.glob(f"{begin}*{goal.ending}"):
        if (known := _cached(cached)) is not None:
            return known
    with tempfile.TemporaryDirectory(dir=folder) as place:
        made = _compile(command, files, Path(place), goal.ending)
        made.chmod(0o600)
        content = made.read_bytes()
        os.replace(made, folder / f"{begin}{checksum(content)}{goal.ending}")
    keep_newest(folder, goal.ending, KEPT)
    return content


def _cached(path: Path) -> bytes | None:
    """Return the content of a library, whose name ends in its checksum; None, with a warning, where it is not used."""
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
    """Return the folder for libraries and FMUs in the user's cache, made if need be.

    Raises OutputError where it cannot be written, or others may write there: what lies in it is executed.
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
    return folder


def keep_newest(folder: Path, ending: str, number: int) -> None:
    """Remove all but the newest files with that ending."""
    with contextlib.suppress(OSError):  # another process may do the same
        found = sorted(folder.glob(f"*{ending}"), key=lambda path: path.stat().st_mtime, reverse=True)
        for path in found[number:]:
            path.unlink()


def _compile(command: Sequence[str], files: Mapping[str, bytes], folder: Path, ending: str) -> Path:
    """Compile in `folder` under plain names, so that the bytes do not depend on where anything lies."""
    for name, content in files.items():
        (folder / name).write_bytes(content)
    names = [name for name in files if name.endswith(".c")]
    result = f"{IDENTIFIER}{ending}"
    try:
        done = subprocess.run(
            [*command, "-o", result, *names, "-lm"],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=TIMEOUT,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise PluginError(f"the C compiler does not run: {error}; set CC to another, or {REMEDY}") from error
    if done.returncode != 0 or not (folder / result).is_file():
        said = done.stderr.strip()[-2000:] or f"exit code {done.returncode}"
        raise PluginError(
            f"the C compiler '{shlex.join(command)}' fails; set CC to another, or {REMEDY}. It says:\n{said}"
        )
    return folder / result
