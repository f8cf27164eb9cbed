"""The C of a part of cables, for exported FMUs: it stands beside the part's kernels, under the name of their folder."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path


def name_in_c(kernels: str) -> str:
    """Return the word before the functions of a part whose kernels are the module `kernels`."""
    return kernels.split(".")[-2]


def source(kernels: str) -> Path:
    """Return where the C of the part would lie; the kernels are not loaded."""
    spec = find_spec(kernels)
    if spec is None or spec.origin is None:
        raise ImportError(f"there are no kernels '{kernels}'")
    return Path(spec.origin).with_name(f"{name_in_c(kernels)}.c")


def in_c(kernels: str) -> bool:
    """Tell whether there is C of that part; of one without kernels there need be none."""
    return bool(kernels) and source(kernels).is_file()
