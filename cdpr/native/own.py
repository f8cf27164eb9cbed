"""Declaration of the C++ source of a plugin's compiled operation, for exported FMUs."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple


class Own(NamedTuple):
    """C++ source of an operation that is not in the kernel library.

    Attributes:
        header: C++ header that uses those of `cdpr.get_include()`.
        symbols: struct and function in it, as arguments of `entry<...>` of `cdpr/entry.hpp`: "Mine, mine".

    Example:
        >>> from pathlib import Path
        >>> Own(Path("mine.hpp"), "Mine, mine").symbols
        'Mine, mine'
    """

    header: Path
    symbols: str
