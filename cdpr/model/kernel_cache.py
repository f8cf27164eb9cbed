"""Where compiled kernels are kept, so that they are compiled once for an installation and never used when stale.

numba renews a cached kernel when its own file changes, but not when a kernel that it calls, from another file, does.
So each state of the sources gets a folder of its own.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import tempfile
import time
import warnings
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

PACKAGES = ("cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers")
KEPT = 5  # folders of other states of the sources: enough to go back and forth between checkouts
UNUSED = 7 * 86400.0  # s; a folder used since then stays in any case


@lru_cache(maxsize=1)
def digest() -> str:
    """Return a fingerprint of all sources that hold kernels."""
    result = hashlib.sha256()
    for package in PACKAGES:
        spec = find_spec(package)
        for root in spec.submodule_search_locations or () if spec else ():
            for path in sorted(Path(root).rglob("*.py")):
                content = path.read_bytes()
                if b"kernel" in content:
                    result.update(path.name.encode() + content)
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
