"""Sources of the kernel library: check that a checkout's library was compiled from them."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

ROOT = Path(__file__).parents[2]
KINDS = (
    *("cdpr/native/*.c", "cdpr/native/*.cpp", "cdpr/native/*.h", "cdpr/native/tables/*.cpp"),
    "cdpr/native/include/**/*.h",
    *("cdpr/**/*.hpp", "cdpr_*/**/*.hpp"),
)


def digest(root: Path = ROOT) -> str | None:
    """Return the digest of the sources in a checkout, computed as in CMakeLists.txt; None outside a checkout."""
    if not (root / "CMakeLists.txt").is_file():
        return None
    found = {path for kind in KINDS for path in root.glob(kind) if not path.is_symlink()}
    names = {path.relative_to(root).as_posix() for path in found} | {"CMakeLists.txt"}
    listing = "".join(f"{name} {sha256((root / name).read_bytes()).hexdigest()}\n" for name in sorted(names))
    return sha256(listing.encode()).hexdigest()
