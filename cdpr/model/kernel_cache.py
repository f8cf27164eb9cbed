"""Where compiled kernels are kept, so that they are compiled once for a state of the sources and never used when stale.

numba renews a cached kernel when its own file changes, but not when a kernel that it calls, from another file, does.
So each state of the sources gets a folder of its own, wherever they lie.
"""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import os
import re
import shutil
import stat
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

from cdpr import ownership
from cdpr.errors import OutputError

PACKAGES = ("cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers")
PASSING = "cdpr-passing-"  # begins the name of a folder that goes with its process
KEPT = 5  # folders of other states of the sources: enough to go back and forth between checkouts
# Each process looks for these in all sources: they begin with fixed letters, which are found many times faster.
DECORATED = re.compile(rb"\n[ \t]*@(?:threaded_)?kernel\b")
TYPES_ONLY = re.compile(rb"\nif TYPE_CHECKING:\n(?:[ \t]+.*\n|[ \t]*\n)*")  # never there when compiled
IMPORTS = re.compile(r"\n[ \t]*(?:from ([\w.]+) import|import) (\([^)]*\)|[^\n]*)")
UNUSED = 7 * 86400.0  # s; a folder used since then stays in any case


@lru_cache(maxsize=1)
def digest() -> str:
    """Return a fingerprint of all our sources that hold kernels."""
    roots: list[Path] = []
    for package in PACKAGES:
        spec = find_spec(package)
        roots += map(Path, spec.submodule_search_locations or () if spec else ())
    files = {f"{root.name}/{name}": content for root in roots for name, content in _sources(root)}
    return _fingerprint(_needed(files))


def _needed(files: dict[str, bytes]) -> dict[str, bytes]:
    """Leave the files that hold kernels, and all that they import: constants from there are compiled in."""
    modules = {name.removesuffix(".py").removesuffix("/__init__").replace("/", "."): name for name in files}
    todo = [name for name, content in files.items() if b"kernel" in content and DECORATED.search(b"\n" + content)]
    needed: dict[str, bytes] = {}
    while todo:
        name = todo.pop()
        if name in needed:
            continue
        needed[name] = files[name]
        text = TYPES_ONLY.sub(b"\n", b"\n" + files[name]).decode(errors="replace")
        for package, what in IMPORTS.findall(text):
            words = re.findall(r"[\w.]+", what)
            found = [package, *(f"{package}.{word}" for word in words)] if package else words
            todo += [modules[module] for module in found if module in modules]
    return needed


def digest_around(module: str) -> str | None:
    """Return a fingerprint of the sources that a kernel of this module may be made of, beside ours.

    Those of its package; of a module that is in none, it and its neighbours, which it may import. For a kernel of ours
    there are no others. None where there is no file, as in a notebook: nothing tells then when a kernel has changed.
    """
    top = module.partition(".")[0]
    return "" if top in PACKAGES else _digest_of(top)


@lru_cache
def _digest_of(top: str) -> str | None:
    found = sys.modules.get(top)
    if folders := getattr(found, "__path__", None):
        roots = list(map(Path, folders))
        return _fingerprint({name: content for root in roots for name, content in _sources(root)})
    file = getattr(found, "__file__", None)
    return _fingerprint(dict(_sources(Path(file).parent, below=False))) if file else None


def _sources(root: Path, *, below: bool = True) -> Iterator[tuple[str, bytes]]:
    """Yield the readable files, with `below` those of all folders in it, by their names as seen from there.

    Editors leave locks (.#name.py, links to nowhere) among them.
    """
    start = os.path.join(root, "")
    for folder, folders, names in os.walk(root):
        if not below:
            folders.clear()
        for name in names:
            if name.endswith(".py") and not name.startswith("."):
                path = os.path.join(folder, name)
                with contextlib.suppress(OSError), open(path, "rb", buffering=0) as file:
                    yield path[len(start) :], file.read()


def _fingerprint(files: dict[str, bytes]) -> str:
    result = hashlib.sha256()
    for name, content in sorted(files.items()):
        result.update(f"{name}\0{len(content)}\0".encode() + content)
    return result.hexdigest()[:16]


def user_cache() -> Path:
    """Return the folder that cdpr may keep in the user's cache, or in the fallback where the user has no home."""
    root = os.environ.get("XDG_CACHE_HOME")
    try:
        return Path(root or Path.home() / ".cache") / "cdpr"
    except RuntimeError:  # no HOME, and a uid that the system does not know
        return fallback()


def folder() -> str:
    """Return the folder for compiled kernels, made if need be.

    It lies in NUMBA_CACHE_DIR or the user's cache; where that cannot be written, or others may write there, in the
    fallback, with a warning.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    root = Path(chosen) if chosen else user_cache()
    path = root / f"kernels-{digest()}"
    try:
        _make_writable(path, path if chosen else root)
    except OSError as error:
        root = fallback()
        reason = f"cannot be written ({error.strerror})" if error.strerror else f"is not used: {error}"
        warnings.warn(
            f"{path} {reason}: compiled kernels are kept in {root}; NUMBA_CACHE_DIR names another folder",
            stacklevel=2,
        )
        path = root / path.name
        try:
            _make_writable(path, root)
        except OSError as second:
            raise unwritable(path, second) from error
    for old in _used_before(root, time.time() - UNUSED)[KEPT:]:
        shutil.rmtree(old, ignore_errors=True)
    return str(path)


@lru_cache(maxsize=1)
def kept() -> Path:
    """Return the folder of compiled kernels; it stays the same in a process."""
    return Path(folder())


@lru_cache(maxsize=1)
def fallback() -> Path:
    """Return the folder that takes the place of the user's cache: one for this user on this machine, kept.

    Others may write beside it, and what lies in it is run: it is believed only where it belongs to the user alone.
    Where somebody else holds the name, a folder of this process takes its place, for its workers too, and goes with it.
    """
    try:
        path = Path(tempfile.gettempdir()) / f"cdpr-{os.geteuid()}"
    except OSError as error:  # no folder for temporary files can be written
        raise unwritable(Path("/tmp"), error) from error
    with contextlib.suppress(OSError):
        path.mkdir(mode=0o700)
    with contextlib.suppress(OSError):
        found = path.lstat()  # a link would be somebody's
        if stat.S_ISDIR(found.st_mode) and found.st_uid == os.geteuid() and not found.st_mode & 0o077:
            return path
    try:
        path = Path(tempfile.mkdtemp(prefix=PASSING))
    except OSError as error:
        raise unwritable(path, error) from error
    atexit.register(shutil.rmtree, path, ignore_errors=True)
    os.environ["NUMBA_CACHE_DIR"] = str(path)
    return path


def lasting() -> bool:
    """Tell whether what is compiled is there for later runs, too."""
    return PASSING not in os.environ.get("NUMBA_CACHE_DIR", "")


def unwritable(path: Path, error: OSError) -> OutputError:
    """Return the error that says that no folder is left for compiled kernels."""
    return OutputError(
        f"{path}: compiled kernels cannot be kept there: {error.strerror or error}; set NUMBA_CACHE_DIR to a folder "
        "that can be written"
    )


def read(name: str) -> bytes | None:
    """Return the content of a file of compiled kernels; None where there is none, or it may not be used."""
    try:
        return ownership.read_private(kept() / name)
    except PermissionError as error:
        warn_rebuilt(f"{error}")
    except OSError:
        pass
    return None


def warn_rebuilt(reason: str) -> None:
    """Warn that compiled code of the cache is not used."""
    warnings.warn(f"{reason}: it is not used, and compiled again", stacklevel=3)


def _make_writable(path: Path, own: Path) -> None:
    """Make a folder where there is none; OSError where it cannot be written, or others may write there."""
    ownership.make_private(path, own)
    os.utime(path)
    with tempfile.TemporaryFile(dir=path):
        pass
    if found := ownership.fault(path):
        raise PermissionError(found)


def _used_before(root: Path, moment: float) -> list[Path]:
    """Return the folders of kernels that no process has begun to use since, the last used first."""
    used: dict[Path, float] = {}
    for folder in root.glob("kernels-*"):
        with contextlib.suppress(OSError):  # another process removes it
            used[folder] = folder.stat().st_mtime
    return sorted((folder for folder in used if used[folder] < moment), key=lambda folder: -used[folder])
