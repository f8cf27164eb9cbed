"""Which name was meant: the one place that compares names."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

COMPARED = 60  # characters of a foreign name; more would take long
ALIKE = 0.6  # least share of what two names have in common


def nearest(name: str, names: Iterable[str], count: int = 1, alike: float = ALIKE) -> list[str]:
    """Return the names that are closest to `name`, the closest first: `count` at most, or none."""
    return difflib.get_close_matches(name[:COMPARED], list(names), count, alike)


def did_you_mean(name: str, names: Iterable[str]) -> str:
    """Return "did you mean 'x'? " or nothing."""
    return "".join(f"did you mean '{near}'? " for near in nearest(name, names))
