"""What a process leaves when it ends: a shared object of the kernels that it has got from numba, for the next ones.

Their code is made anew of LLVM's, such that it can lie anywhere in memory (numba's cannot), and linked by the system's
C compiler together with `calls.c`. Where there is no compiler, or no place, numba serves the next process, too.
"""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from cdpr.model import kernel_cache, objects
from cdpr.model.kinds import packed, text
from cdpr.model.numba_kinds import kind_from
from cdpr.model.pieces import Pieces

FLAGS = "-shared", "-fPIC", "-O2", "-Wl,-Bsymbolic", "-Wl,-z,noexecstack", "-s"
SECONDS = 120.0  # after which a linker hangs: it takes one
MOST = 32  # files of one environment: the oldest go, what they held is linked again by whom it is missing

_wanted: dict[tuple[int, Any], Any] = {}  # dispatchers, with the types of numba's for which they are


def wanted(dispatcher: Any, args: tuple[Any, ...] | None) -> None:
    """Take down that a kernel is called from outside, for these types of numba's; for all that there are by Python."""
    if not _wanted:
        atexit.register(_leave, os.getpid())
    _wanted[id(dispatcher), args] = dispatcher


def _leave(process: int) -> None:
    if os.getpid() == process:  # a forked child that ends so has its own
        with contextlib.suppress(Exception, KeyboardInterrupt):  # whatever it is, it must not spoil what was done
            leave()


def leave() -> Path | None:
    """Leave a shared object of what is in none yet; return where, or None where there is nothing to leave or no way."""
    environment, compiler = objects.environment(), shutil.which(os.environ.get("CC") or "cc")
    if environment is None or compiler is None or not kernel_cache.lasting():
        return None
    objects._libraries.cache_clear()  # another process may have left some meanwhile
    known = objects.libraries()
    if not all(library.runs for found in known.values() for library in found if library.ours):
        return None  # another one would not run either
    missing: dict[str, tuple[Any, Any]] = {}
    pairs = [(each, args) for (_, given), each in _wanted.items() for args in ([given] if given else each.overloads)]
    for dispatcher, args in pairs:
        kinds = tuple(map(kind_from, args))
        compiled = dispatcher.overloads.get(args)
        if compiled is None or dispatcher.key_of is None or None in kinds:
            continue
        key = dispatcher.key_of(", ".join(text(kind) for kind in kinds if kind is not None))
        if key is not None and (key not in known or not _settled(key)):
            missing[key] = kinds, compiled
    if not missing:
        return None
    folder = kernel_cache.kept()
    for old in sorted(folder.glob(objects.pattern(environment)), key=os.path.getmtime)[: 1 - MOST]:
        old.unlink()
    with tempfile.TemporaryDirectory() as place:
        content = _linked(missing, Path(place), compiler)
    return _write(objects.pattern(environment).replace("*", hashlib.sha256(content).hexdigest()), content)


def _settled(key: str) -> bool:
    return any(library.entries[key] is None for library in objects.libraries()[key]) or objects.find(key) is not None


def _linked(missing: dict[str, tuple[Any, Any]], place: Path, compiler: str) -> bytes:
    """Return the content of a shared object."""
    pieces = Pieces()
    entries: dict[str, Any] = {}
    for key, (kinds, compiled) in missing.items():
        result = kind_from(compiled.signature.return_type)
        piece = pieces.add(compiled) if objects.fits(kinds, result) else None
        entries[key] = None
        if piece is not None and result is not None:
            entries[key] = [piece.name, pieces.add_entry(compiled, piece), packed(result), sorted(piece.foreign)]
    machine, target = place / "kernels.o", place / "kernels.so"
    machine.write_bytes(pieces.machine())
    words = [compiler, *FLAGS, "-o", str(target), str(objects.CALLS), str(machine), "-lm"]
    subprocess.run(words, check=True, timeout=SECONDS, stdin=subprocess.DEVNULL, capture_output=True)
    return objects.with_index(target.read_bytes(), entries)


def _write(name: str, content: bytes) -> Path:
    """Write a file that is whole or not there."""
    part = None
    target = kernel_cache.kept() / name
    try:
        with tempfile.NamedTemporaryFile(dir=target.parent, delete=False) as file:
            part = file.name
            file.write(content)
        os.replace(part, target)
    except BaseException:
        if part is not None:
            with contextlib.suppress(OSError):
                os.unlink(part)
        raise
    return target
