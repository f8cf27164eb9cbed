"""Shared objects of compiled kernels: what runs without numba, which takes longer to start than a short run takes.

A process that has compiled kernels, or loaded them by numba, leaves them as such a file when it ends (`linker`). After
the code stand an index of what it holds, the index's length and a checksum of it all, which is in the file's name, too:
what is not whole is not loaded. Nothing is written into a file that has this name.

A wheel may bring such files, made for any processor of its kind when it was built (build_backend.py): they serve as
long as the sources beside them are those that they were made of, whatever numba is installed.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import json
import os
import struct
import sys
from collections.abc import Callable, Iterator
from functools import cache, cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cdpr.model import kernel_cache
from cdpr.model.kinds import C_INT, NOTHING, NUMBER, TRUTH, WHOLE, Block, Group, Kind, unpacked

CALLS = Path(__file__).with_name("calls.c")
BROUGHT = Path(__file__).parents[1] / "kernels"  # by a wheel, in a folder for the state of the sources
LENGTH = struct.Struct("<Q")
CHECKSUM = hashlib.sha256().digest_size
HEAD = 16  # bytes of each object in a Python whose objects calls.c knows
FLAGS = 64  # where an array's flags stand in it
CODES = {NUMBER: 0, WHOLE: 1, C_INT: 1, TRUTH: 2, NOTHING: 5}  # of calls.c, which has these two, too:
BLOCK, GROUP = 3, 4
MOST_WORDS, MOST_RESULTS = 160, 16  # likewise
PROCESSOR = b"flags", b"Features", b"model name", b"CPU "  # begin lines of /proc/cpuinfo that tell what it can do
FIRST = 1 << 13  # bytes of that, with the first processor: each further one costs as much time
# What does not change the code.
IDLE = "NUMBA_CACHE_DIR", "NUMBA_NUM_THREADS", "NUMBA_THREADING_LAYER"


class Needed(NamedTuple):
    """A kernel of another package that the code holds: it is not to be used when that has changed."""

    module: str
    name: str
    types: str
    key: str


class Found(NamedTuple):
    """A kernel in memory: its address, that of what takes words, and what it returns, None where no kind says that."""

    address: int
    entry: int
    result: Kind | None


class Library:
    """One file. `entries` tells of each key in it the code's names, what it returns, and what must not have changed.

    Of what cannot be in such a file the entry is None. It is `ours` where no wheel brought it.
    """

    def __init__(self, path: Path, entries: dict[str, Any], ours: bool) -> None:
        self._path, self.entries, self.ours = path, entries, ours

    def find(self, key: str) -> Found | None:
        """Return a kernel; None where it cannot be loaded."""
        address, entry, result, needed = self.entries[key]
        if not all(_unchanged(Needed(*each)) for each in needed) or self._code is None:
            return None
        return Found(_address(self._code, address), _address(self._code, entry), unpacked(result))

    @property
    def runs(self) -> bool:
        """Whether it can be loaded: not so where a folder's files may not be run."""
        return self._code is not None

    @cached_property
    def _code(self) -> Any:
        try:
            return ctypes.PyDLL(str(self._path))
        except OSError:
            return None

    @cached_property
    def make(self) -> Any:
        """What makes a call of a description and of what is called otherwise."""
        made = self._code.cdpr_make
        made.restype, made.argtypes = ctypes.py_object, (ctypes.py_object,)
        return made


def find(key: str) -> tuple[Found, Library] | None:
    """Return a kernel that earlier processes have left, and where it is; None where there is none."""
    for library in libraries().get(key, ()):
        if library.entries[key] is not None and (found := library.find(key)) is not None:
            return found, library
    return None


def call(found: Found, library: Library, kinds: tuple[Kind, ...], otherwise: Callable[..., Any]) -> Callable[..., Any]:
    """Return what Python calls with arguments of these kinds; others, and errors, go to `otherwise`."""
    words = [found.entry, id(np.ndarray), id(np.float64), id(np.int64), len(kinds)]
    for kind in kinds:
        words += _described(kind, typed=True)
    words += _described(found.result or NOTHING, typed=False)
    made: Callable[..., Any] = library.make((struct.pack(f"{len(words)}q", *words), otherwise))
    return made


def libraries() -> dict[str, list[Library]]:
    """Return the files of this state of the sources that hold a key, by key."""
    name = environment()
    return _libraries(None if name is None else kernel_cache.kept(), name or "")


def pattern(name: str) -> str:
    """What the names of files for an environment look like."""
    return f"objects-{name}-*.so"


@cache
def _libraries(folder: Path | None, name: str) -> dict[str, list[Library]]:
    found: dict[str, list[Library]] = {}
    brought = portable()
    several = [] if brought is None else list(_whole(BROUGHT / f"kernels-{kernel_cache.digest()}", brought, ours=False))
    if folder is not None:
        several += _whole(folder, name, ours=True)
    for library in several:
        for key in library.entries:
            found.setdefault(key, []).append(library)
    return found


def _whole(folder: Path, name: str, *, ours: bool) -> Iterator[Library]:
    """Yield the files that are whole; those of `ours` that are not are removed."""
    for path in sorted(folder.glob(pattern(name))):
        with contextlib.suppress(OSError):
            content = kernel_cache.read(path.name) if ours else path.read_bytes()
            whole = content is not None and hashlib.sha256(content).hexdigest() == path.stem.rpartition("-")[2]
            entries = index(content) if whole and content is not None else None
            if entries is not None:
                yield Library(path, entries, ours)
            elif ours:
                if content is not None:
                    kernel_cache.warn_rebuilt(f"{path} is damaged")
                path.unlink()  # what uses it now keeps what it has mapped


def index(content: bytes) -> dict[str, Any] | None:
    """Return the index of a file; None where it has none."""
    try:
        (length,) = LENGTH.unpack(content[-LENGTH.size :])
        found = json.loads(content[-LENGTH.size - length : -LENGTH.size])
    except (struct.error, ValueError):
        return None
    return found if isinstance(found, dict) else None


def with_index(code: bytes, entries: dict[str, Any]) -> bytes:
    """Return the content of a file."""
    text = json.dumps(entries).encode()
    return code + text + LENGTH.pack(len(text))


@cache
def environment() -> str | None:
    """Return what tells apart machines, compilers and their settings; None where no such files can be used."""
    try:
        with open("/proc/cpuinfo", "rb", buffering=0) as file:
            cpu = file.read(FIRST).partition(b"\n\n")[0]
        told = [line for line in cpu.splitlines() if line.startswith(PROCESSOR)]
        versions = [_version(package) for package in ("numba", "llvmlite")]
    except (OSError, AttributeError, TypeError, ValueError):
        return None
    return fingerprint(told, versions, _settings()) if told else None


@cache
def portable() -> str | None:
    """Return what tells apart the machines that can use what a wheel brings; None where none can be used."""
    return None if _settings() else fingerprint()


def brought_by() -> str | None:
    """Return the version of numba that made what a wheel brings for these sources; None where it brings nothing."""
    try:
        return None if portable() is None else (BROUGHT / f"kernels-{kernel_cache.digest()}" / "numba").read_text()
    except OSError:
        return None


def _settings() -> list[tuple[str, str]]:
    """What the user says of how numba is to compile."""
    return sorted(item for item in os.environ.items() if item[0].startswith("NUMBA_") and item[0] not in IDLE)


def fingerprint(*what: object) -> str | None:
    """Return what tells apart what calls.c is made for, and more; None where that is not this Python."""
    try:
        calls = CALLS.read_bytes()
    except OSError:
        return None
    if not _known_layout():
        return None
    all_ = repr((*what, calls, sys.implementation.cache_tag, os.uname().machine))
    return hashlib.sha256(all_.encode()).hexdigest()[:16]


def _version(package: str) -> bytes:
    spec = find_spec(package)
    if spec is None or spec.origin is None:
        raise OSError(f"{package} is not there")
    return Path(spec.origin).with_name("_version.py").read_bytes()


def _known_layout() -> bool:
    """Whether objects and arrays are laid out as calls.c has them."""
    if sys.implementation.name != "cpython" or sys.platform != "linux" or object.__basicsize__ != HEAD:
        return False
    probe = np.zeros((2, 3))
    data, dimensions = struct.unpack("qi", ctypes.string_at(id(probe) + HEAD, 12))
    flags = ctypes.c_int.from_address(id(probe) + FLAGS).value
    (item,) = struct.unpack("q", ctypes.string_at(id(probe) + FLAGS - 8, 8))
    return bool(data == probe.ctypes.data and dimensions == 2 and item == id(probe.dtype) and flags == probe.flags.num)


def fits(kinds: tuple[Kind, ...], result: Kind | None) -> bool:
    """Whether calls.c can call what takes and returns these."""
    try:
        most = sum(_words(kind) for kind in kinds) < MOST_WORDS
        return most and result is not None and len(_described(result, typed=False)) <= MOST_RESULTS
    except (KeyError, AttributeError):
        return False


def _words(kind: Kind) -> int:
    if isinstance(kind, Block):
        return 1 + kind.dimensions
    return sum(map(_words, kind.items)) if isinstance(kind, Group) else 1 + 0 * CODES[kind]  # type: ignore[index]


def _described(kind: Kind, *, typed: bool) -> list[int]:
    if isinstance(kind, Block):
        return [BLOCK, kind.dimensions, id(np.dtype(kind.item.name))]
    if isinstance(kind, Group):
        made = [id(kind.made or tuple)] if typed else []
        return [GROUP, *made, len(kind.items), *(each for item in kind.items for each in _described(item, typed=typed))]
    return [CODES[kind]]  # type: ignore[index]


def _unchanged(needed: Needed) -> bool:
    kernel: Any = getattr(sys.modules.get(needed.module), needed.name, None)
    return hasattr(kernel, "key_of") and kernel.key_of(needed.types) == needed.key


def _address(code: Any, name: str) -> int:
    return int(ctypes.cast(getattr(code, name), ctypes.c_void_p).value or 0)
