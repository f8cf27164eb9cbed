"""Declaration of the C++ source of a plugin's compiled operation, for exported FMUs."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple


class Own(NamedTuple):
    """C++ of an operation that is not in the kernel library.

    Attributes:
        header: C++ header built on those of `cdpr.get_include()`.
        arguments: Struct and function in it, as `entry<...>` of `cdpr/entry.hpp` takes them: "Mine, mine".

    Example:
        >>> Own(Path(__file__).with_name("mine.hpp"), "Mine, mine")
    """

    header: Path
    arguments: str
