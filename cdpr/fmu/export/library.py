"""Compilation of an FMU's C++ source with the system's compiler or zig, once for each state of the source."""

from __future__ import annotations

import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from cdpr.base.errors import PluginError
from cdpr.fmu.export.cache import TIMEOUT, fmu_cache, kept
from cdpr.fmu.export.description import IDENTIFIER
from cdpr.native.entries import TABLE, headers_of, table

SOURCE = Path(__file__).parent / "source"
STANDARD = SOURCE.with_name("fmi")  # headers of FMI, which are third-party

# Products are not fused with sums: the bits are those of the backend `reference`. Only the functions of FMI are visible
# from outside, so that several such libraries can be loaded into one process.
FLAGS = (
    *("-std=c++17", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off", "-fno-exceptions"),
    *("-fno-rtti", "-I."),
)

KEPT = 20  # libraries of other models and states of the source, or by other compilers
KEPT_OBJECTS = 20 * KEPT  # a library has about 13

INCLUDED = re.compile(r'^ *# *include *[<"]([^>"]+)[>"]', re.MULTILINE)

# Platform names of FMI 2; FMI 3 uses MACHINE-linux.
FOLDERS = {"x86_64": "linux64", "i686": "linux32"}

NATIVE, WINDOWS = "native", "win64"
CROSS = "x86_64-w64-mingw32-g++"

# Windows: C99 rules for reading and printing numbers, no other library, no timestamp: the same bytes.
CROSS_FLAGS = ("-D__USE_MINGW_ANSI_STDIO=1", "-static-libgcc", "-static-libstdc++", "-s", "-Wl,--no-insert-timestamp")

# Linux: no dependency on the C++ library, so that the FMU does not load it.
LINUX_FLAGS = ("-Wl,--as-needed",)

# Ignored by compilers without linking; some warn.
LINKER_FLAGS = ("-shared", "-s", *LINUX_FLAGS, "-static-libgcc", "-static-libstdc++", "-Wl,--no-insert-timestamp")

MATHEMATICS = {".so": ("-lm",), ".dll": ("-lm",)}

# zig would otherwise first compile the C++ library, which the FMU does not need.
ZIG_FLAGS = ("-nostdlib++",)

REMEDY = "give --source-only for an FMI 3 FMU with its C++ source alone, to be compiled where it is used"


class Cross(NamedTuple):
    """Another platform, for which zig compiles: its names in FMI 2, if it has one, FMI 3 and zig."""

    fmi2: str
    fmi3: str
    zig: str
    ending: str


CROSSES = {
    WINDOWS: Cross("win64", "x86_64-windows", "x86_64-windows-gnu", ".dll"),
    "linux-x86_64": Cross("linux64", "x86_64-linux", "x86_64-linux-gnu.2.17", ".so"),
    "linux-aarch64": Cross("", "aarch64-linux", "aarch64-linux-gnu.2.17", ".so"),
    "macos-x86_64": Cross("darwin64", "x86_64-darwin", "x86_64-macos", ".dylib"),
    "macos-aarch64": Cross("", "aarch64-darwin", "aarch64-macos", ".dylib"),
}

# Platforms for binaries: that of the exporter, and those above.
PLATFORMS = (NATIVE, *CROSSES)


def sources() -> dict[str, bytes]:
    """Return the C++ files and headers of an FMU without controller by name, in this order."""
    own = [path for folder in (SOURCE, STANDARD) for path in folder.iterdir() if path.suffix in (".cpp", ".h")]
    files = {path.name: path.read_bytes() for path in own} | {TABLE: table(())}
    return dict(sorted({**files, **headers_of(content.decode() for content in files.values())}.items()))


@dataclass(frozen=True)
class Target:
    """Platform for which a binary can be compiled.

    Attributes:
        folder: folder of its binaries inside an FMU.
        command: command of the C++ compiler, its program as an absolute path.
        flags: additional flags for this platform.
    """

    folder: str
    ending: str
    command: tuple[str, ...]
    flags: tuple[str, ...] = ()


def target(name: str, fmi: int) -> Target:
    """Return one of PLATFORMS.

    Raises:
        PluginError: if there is no compiler for it, or FMI has no name for it.
    """
    if name != NATIVE:
        cross = CROSSES[name]
        folder = cross.fmi2 if fmi == 2 else cross.fmi3
        if not folder:
            raise PluginError(f"FMI 2 has no name for {name}: choose --fmi 3, or leave --platform {name} out")
        return Target(folder, cross.ending, *_cross_compiler(name, cross))
    machine = platform.machine()
    if sys.platform != "linux" or (fmi == 2 and machine not in FOLDERS):
        raise PluginError(f"FMI {fmi} binaries cannot be built on {sys.platform} {machine}: {REMEDY}")
    return Target(FOLDERS[machine] if fmi == 2 else f"{machine}-linux", ".so", tuple(compiler()), LINUX_FLAGS)


def _cross_compiler(name: str, cross: Cross) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the command of a compiler for another platform, and its flags."""
    program = shutil.which(CROSS) if name == WINDOWS else None
    if program is not None:
        return (program,), CROSS_FLAGS
    if (zig := zig_program()) is None:
        mingw = f"'{CROSS}' (such as the package g++-mingw-w64-x86-64) or " if name == WINDOWS else ""
        raise PluginError(
            f"there is no compiler for {name}: install {mingw}zig (pip install 'cdpr[cross]'), omit --platform {name}, "
            f"or {REMEDY}"
        )
    return (zig, "c++", "-target", cross.zig, *ZIG_FLAGS), ("-s",)


def zig_program() -> str | None:
    """Return the zig compiler of the package ziglang; None if that is not installed."""
    try:
        spec = find_spec("ziglang")
    except (ImportError, ValueError):
        return None
    if spec is None or spec.origin is None:
        return None
    path = Path(spec.origin).with_name("zig.exe" if sys.platform == "win32" else "zig")
    return str(path) if path.is_file() else None


def compiler() -> list[str]:
    """Return the command of the C++ compiler for this platform: $CXX, c++ or zig, its program as an absolute path."""
    given = os.environ.get("CXX", "").strip()
    try:
        words = shlex.split(given or "c++")
    except ValueError as error:
        raise PluginError(
            f"CXX: expected a command, such as g++, got {given!r} ({error}); set it, or {REMEDY}"
        ) from None
    program = shutil.which(words[0])
    if program is None and not given and (zig := zig_program()) is not None:
        return [zig, "c++", "-target", f"{platform.machine()}-linux-gnu.2.17", *ZIG_FLAGS]
    if program is None:
        raise PluginError(
            f"there is no C++ compiler: '{words[0]}' is not found; install one (such as the package g++, or zig by "
            f"pip install ziglang), set CXX, or {REMEDY}"
        )
    return [program, *words[1:]]


def library(files: Mapping[str, bytes], flags: Sequence[str] = FLAGS, goal: Target | None = None) -> bytes:
    """Return the shared library of the C++ files among `files`, contents by name; from the user's cache if present.

    The default `goal` is this platform; the cache identifies compilers by name, flags and machine. Objects of files
    that do not depend on the model come from the cache for other models, too.
    """
    goal = goal or Target("", ".so", tuple(compiler()), LINUX_FLAGS)
    command = [*goal.command, *flags, *goal.flags]
    return kept(command, files, goal.ending, KEPT, lambda place: _link(command, files, place, goal.ending))


def _link(command: Sequence[str], files: Mapping[str, bytes], folder: Path, ending: str) -> Path:
    names = [name for name in files if name.endswith(".cpp")]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = list(pool.map(lambda name: _object(command, name, _closure(name, files)), names))
    for name, content in zip(names, objects, strict=True):
        (folder / f"{name}.o").write_bytes(content)
    library = folder / f"{IDENTIFIER}{ending}"
    _call([*command, "-o", library.name, *(f"{name}.o" for name in names), *MATHEMATICS.get(ending, ())], library)
    return library


def _object(command: Sequence[str], name: str, files: Mapping[str, bytes]) -> bytes:
    """Return the object code of a file, compiled under a relative name, so that it does not depend on the location."""
    command = [*(word for word in command if word not in LINKER_FLAGS), "-c", name]

    def make(folder: Path) -> Path:
        for other, content in files.items():
            path = folder / other
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        file = folder / f"{name}.o"
        _call([*command, "-o", file.name], file)
        return file

    return kept(command, files, ".o", KEPT_OBJECTS, make)


def _closure(name: str, files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return a file and the ones that it includes, directly or not."""
    found: dict[str, bytes] = {}
    todo = [name]
    while todo:
        name = todo.pop()
        if name in files and name not in found:
            found[name] = files[name]
            todo += INCLUDED.findall(files[name].decode())
    return dict(sorted(found.items()))


def _call(command: Sequence[str], target: Path) -> None:
    """Call a compiler in the folder of the file that it writes."""
    try:
        done = subprocess.run(
            command,
            cwd=target.parent,
            env={**os.environ, **_zig_cache(command)},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=TIMEOUT,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise PluginError(f"the C++ compiler does not run: {error}; set CXX to another, or {REMEDY}") from error
    if done.returncode != 0 or not target.is_file():
        output = done.stderr.strip()[-2000:] or f"exit code {done.returncode}"
        raise PluginError(
            f"the C++ compiler '{shlex.join(command)}' fails; set CXX to another, or {REMEDY}. Its output:\n{output}"
        )


def _zig_cache(command: Sequence[str]) -> dict[str, str]:
    """Return zig's cache folder, for example for the C library of a platform: in the user's cache."""
    if zig_program() not in command:
        return {}
    folder = str(fmu_cache() / "zig")
    return {"ZIG_GLOBAL_CACHE_DIR": folder, "ZIG_LOCAL_CACHE_DIR": folder}
