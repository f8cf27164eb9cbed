"""Where compiled kernels are kept, so that they are compiled once for a state of the sources and never used when stale.

numba renews a cached kernel when its own file changes, but not when a kernel that it calls, from another file, does.
So each state of the sources gets a folder of its own, wherever they lie.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import sys
import tempfile
import time
import warnings
from collections.abc import Iterable
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

PACKAGES = ("cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers")
KEPT = 5  # folders of other states of the sources: enough to go back and forth between checkouts
ANY = "*.py"
UNUSED = 7 * 86400.0  # s; a folder used since then stays in any case


@lru_cache(maxsize=1)
def digest() -> str:
    """Return a fingerprint of all our sources that hold kernels."""
    roots: list[Path] = []
    for package in PACKAGES:
        spec = find_spec(package)
        roots += map(Path, spec.submodule_search_locations or () if spec else ())
    return _fingerprint((f"{root.name}/{path.relative_to(root)}", path) for root in roots for path in root.rglob(ANY))


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
        return _fingerprint((str(path.relative_to(root)), path) for root in roots for path in root.rglob(ANY))
    file = getattr(found, "__file__", None)
    return _fingerprint((path.name, path) for path in Path(file).parent.glob(ANY)) if file else None


def _fingerprint(files: Iterable[tuple[str, Path]]) -> str:
    result = hashlib.sha256()
    for name, path in sorted(files):
        content = path.read_bytes()
        if b"kernel" in content:
            result.update(f"{name}\0{len(content)}\0".encode() + content)
    return result.hexdigest()[:16]


def user_cache() -> Path:
    """Return the folder that cdpr may keep in the user's cache; it need not exist."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "cdpr"


def folder() -> str:
    """Return the folder for compiled kernels, made if need be.

    It lies in NUMBA_CACHE_DIR or the user's cache; where neither can be written, in a temporary folder, with a warning.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    root = Path(chosen) if chosen else user_cache()
    path = root / f"kernels-{digest()}"
    try:
        path.mkdir(parents=True, exist_ok=True)
        os.utime(path)
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as error:
        warnings.warn(
            f"{path} cannot be written ({error.strerror}): kernels are compiled anew in each run; "
            "set NUMBA_CACHE_DIR to a folder that can",
            stacklevel=2,
        )
        return tempfile.mkdtemp(prefix="cdpr-kernels-")
    for old in _used_before(root, time.time() - UNUSED)[KEPT:]:
        shutil.rmtree(old, ignore_errors=True)
    return str(path)


def _used_before(root: Path, moment: float) -> list[Path]:
    """Return the folders of kernels that no process has begun to use since, the last used first."""
    used: dict[Path, float] = {}
    for folder in root.glob("kernels-*"):
        with contextlib.suppress(OSError):  # another process removes it
            used[folder] = folder.stat().st_mtime
    return sorted((folder for folder in used if used[folder] < moment), key=lambda folder: -used[folder])
